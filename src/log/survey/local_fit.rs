//! Fits lines and parabolas to the fixes around a time by least squares.

/// A position with the time at which it was true.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimedPosition {
    pub(super) time_s: f64,
    /// The position, metres east and north.
    pub(super) place_m: [f64; 2],
    /// Weight in the fit: the time for which the recorder repeated the position, seconds.
    pub(super) weight: f64,
}

/// Weighted least-squares fit around a time: a line for the velocity, a parabola for the position
/// (in a turn a line is inside the curve by up to a metre).
pub(super) struct LocalFit {
    /// Position at the time, metres east and north.
    pub(super) position: [f64; 2],
    /// Velocity at the time, metres a second east and north.
    pub(super) velocity: [f64; 2],
    /// Root mean square distance of the places from the curve, metres.
    pub(super) misfit_m: f64,
}

/// Weighted sums over the places in a window, with time in half windows.
#[derive(Default)]
struct Moments {
    /// Sums of the powers 0 to 4 of time.
    time: [f64; 5],
    /// Sums of east and of north, times the powers 0 to 2 of time.
    place: [[f64; 3]; 2],
}

impl Moments {
    fn over(places: &[TimedPosition], time_s: f64, half_window_s: f64) -> Self {
        let mut moments = Self::default();
        for place in places {
            let t = (place.time_s - time_s) / half_window_s;
            // Tapered, so that the track does not jump when a fix enters the window.
            let mut power = place.weight * (1.0 - t * t).max(0.01);
            for (order, sum) in moments.time.iter_mut().enumerate() {
                *sum += power;
                if order < 3 {
                    moments.place[0][order] += power * place.place_m[0];
                    moments.place[1][order] += power * place.place_m[1];
                }
                power *= t;
            }
        }
        moments
    }

    /// Returns the coefficients of the least-squares line; `None` when the places span no time.
    fn line(&self, axis: usize) -> Option<[f64; 3]> {
        let ([s0, s1, s2, ..], [m0, m1, _]) = (self.time, self.place[axis]);
        let determinant = s0 * s2 - s1 * s1;
        (determinant > 1e-6 * s0 * s0)
            .then(|| [(s2 * m0 - s1 * m1) / determinant, (s0 * m1 - s1 * m0) / determinant, 0.0])
    }

    /// Returns the coefficients of the least-squares parabola; `None` when the places have too few
    /// distinct times.
    fn parabola(&self, axis: usize) -> Option<[f64; 3]> {
        let ([s0, s1, s2, s3, s4], [m0, m1, m2]) = (self.time, self.place[axis]);
        let determinant = determinant([[s0, s1, s2], [s1, s2, s3], [s2, s3, s4]]);
        (determinant > 1e-6 * s0.powi(3)).then(|| {
            [
                [[m0, s1, s2], [m1, s2, s3], [m2, s3, s4]],
                [[s0, m0, s2], [s1, m1, s3], [s2, m2, s4]],
                [[s0, s1, m0], [s1, s2, m1], [s2, s3, m2]],
            ]
            .map(|numerator| self::determinant(numerator) / determinant)
        })
    }

    /// Returns true if there are about as many places before the time as after it.
    fn balanced(&self) -> bool {
        self.time[1].abs() < 0.15 * self.time[0]
    }
}

fn determinant([[a, b, c], [d, e, f], [g, h, i]]: [[f64; 3]; 3]) -> f64 {
    a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
}

impl LocalFit {
    /// Fits places within half a window around a time; `None` when the places do not span any time.
    ///
    /// Three or four places, as a slow recorder has in a window, give a parabola only if a line
    /// misses them by more than `bends_beyond_m`: a parabola hardly smooths so few.
    pub(super) fn over(
        places: &[TimedPosition],
        time_s: f64,
        half_window_s: f64,
        bends_beyond_m: f64,
    ) -> Option<Self> {
        let moments = Moments::over(places, time_s, half_window_s);
        let lines = [moments.line(0)?, moments.line(1)?];
        let [east, north] = lines;
        let curved = moments.balanced()
            && match places.len() {
                0..3 => false,
                3 | 4 => misfit_m(places, time_s, half_window_s, lines) > bends_beyond_m,
                _ => true,
            };
        let curve = |axis, line| moments.parabola(axis).filter(|_| curved).unwrap_or(line);
        let curves = [curve(0, east), curve(1, north)];
        Some(Self {
            velocity: [east[1], north[1]].map(|step| step / half_window_s),
            position: curves.map(|curve| curve[0]),
            misfit_m: misfit_m(places, time_s, half_window_s, curves),
        })
    }
}

fn misfit_m(
    places: &[TimedPosition],
    time_s: f64,
    half_window_s: f64,
    curves: [[f64; 3]; 2],
) -> f64 {
    let (mut square, mut weight) = (0.0, 0.0);
    for place in places {
        let t = (place.time_s - time_s) / half_window_s;
        let [east, north] = curves.map(|[a, b, c]| a + t * (b + t * c));
        let [east_m, north_m] = place.place_m;
        square += place.weight * ((east_m - east).powi(2) + (north_m - north).powi(2));
        weight += place.weight;
    }
    (square / weight).sqrt()
}
