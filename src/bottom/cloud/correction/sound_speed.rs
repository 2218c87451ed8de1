//! Provides the speed of sound in the water, and the speed that the recorder assumed.

use serde::{Deserialize, Serialize};

/// Speed of sound that a recorder is taken to assume: 1500 m/s, usual for sea water. Some recorders
/// assume 4800 feet a second (1463 m/s), usual for fresh water, or let their owner choose; logs of
/// fish-finders do not record it.
const RECORDER_M_S: f64 = 1500.0;

/// `sound_speed.*` settings. Without `m_s` and `temperature_c` ranges stay as the recorder computed
/// them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SoundSpeedSettings {
    /// Speed of sound, metres a second, as measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub m_s: Option<f64>,
    /// Temperature of the water, degrees Celsius, to compute the speed from ([`sound_speed_m_s`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Practical salinity: 0 in fresh water, 35 in the ocean.
    pub salinity_psu: f64,
    /// Depth at which temperature and salinity hold, metres: half the water's depth where they are
    /// the same throughout.
    pub depth_m: f64,
    /// Speed of sound that the recorder computed its ranges and depths with, metres a second.
    pub recorder_m_s: f64,
}

impl Default for SoundSpeedSettings {
    fn default() -> Self {
        Self {
            m_s: None,
            temperature_c: None,
            salinity_psu: 0.0,
            depth_m: 0.0,
            recorder_m_s: RECORDER_M_S,
        }
    }
}

impl SoundSpeedSettings {
    /// Returns the speed of sound, metres a second; `None` where the settings give none.
    pub fn water_m_s(&self) -> Option<f64> {
        let computed = |celsius| sound_speed_m_s(celsius, self.salinity_psu, self.depth_m);
        self.m_s.or(self.temperature_c.map(computed))
    }

    /// Checks that the settings give the speed in one way only.
    ///
    /// # Errors
    /// A sentence if they give both a speed and a temperature.
    pub fn check(&self) -> Result<(), &'static str> {
        match (self.m_s, self.temperature_c) {
            (Some(_), Some(_)) => Err(
                "sound_speed.m_s and sound_speed.temperature_c say the same thing twice; give one of them",
            ),
            _ => Ok(()),
        }
    }
}

/// Coefficients of Chen and Millero: `c = Cw + A s + B s^1.5 + D s^2`, each a polynomial in
/// temperature (columns) and pressure in bar (rows).
const C_W: [[f64; 6]; 4] = [
    [1402.388, 5.03711, -5.80852e-2, 3.3420e-4, -1.478e-6, 3.1464e-9],
    [0.153563, 6.8982e-4, -8.1788e-6, 1.3621e-7, -6.1185e-10, 0.0],
    [3.126e-5, -1.7107e-6, 2.5974e-8, -2.5335e-10, 1.0405e-12, 0.0],
    [-9.7729e-9, 3.8504e-10, -2.3643e-12, 0.0, 0.0, 0.0],
];
const A: [[f64; 5]; 4] = [
    [1.389, -1.262e-2, 7.164e-5, 2.006e-6, -3.21e-8],
    [9.4742e-5, -1.2580e-5, -6.4885e-8, 1.0507e-8, -2.0122e-10],
    [-3.9064e-7, 9.1041e-9, -1.6002e-10, 7.988e-12, 0.0],
    [1.1e-10, 6.649e-12, -3.389e-13, 0.0, 0.0],
];
const B: [[f64; 2]; 2] = [[-1.922e-2, -4.42e-5], [7.3637e-5, 1.7945e-7]];
const D: [[f64; 1]; 2] = [[1.727e-3], [-7.9836e-6]];

/// Returns the speed of sound, metres a second, in water of a temperature (0 to 40 C) and a
/// practical salinity (0 to 40) at a depth.
///
/// The UNESCO equation: Chen and Millero, J. Acoust. Soc. Am. 62 (1977) 1129, as printed by
/// Fofonoff and Millard, UNESCO Technical Papers in Marine Science 44 (1983) 46. It holds in fresh
/// water too, which the equations of Mackenzie (1981) and Del Grosso (1974) do not. The pressure is
/// taken as a tenth of a bar a metre, within 3 %: in 100 m that is 0.05 m/s.
pub(super) fn sound_speed_m_s(temperature_c: f64, salinity_psu: f64, depth_m: f64) -> f64 {
    at_pressure(temperature_c, salinity_psu, 0.1 * depth_m)
}

fn at_pressure(t: f64, s: f64, bar: f64) -> f64 {
    polynomial(&C_W, t, bar)
        + polynomial(&A, t, bar) * s
        + polynomial(&B, t, bar) * s.powf(1.5)
        + polynomial(&D, t, bar) * s * s
}

/// Returns a polynomial by Horner's rule over rows of pressure and columns of temperature.
fn polynomial<const N: usize>(rows: &[[f64; N]], t: f64, bar: f64) -> f64 {
    let row = |row: &[f64; N]| row.iter().rev().fold(0.0, |sum, factor| sum * t + factor);
    rows.iter().rev().fold(0.0, |sum, factors| sum * bar + row(factors))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_those_of_unesco() {
        // The check value of Fofonoff and Millard (1983), page 48: S 40, T 40 C, 10 000 dbar. The
        // others by the Python package `seawater` 3.3.5 (`svel(s, t / 1.00024, p)`: it takes
        // temperatures of 1990, the equation those of 1968).
        for (t, s, bar, expected) in [
            (40.0, 40.0, 1000.0, 1731.995),
            (20.0, 0.0, 0.0, 1482.343308),
            (5.0, 0.0, 0.0, 1426.162281),
            (25.0, 0.0, 2.0, 1497.022935),
            (10.0, 35.0, 0.0, 1489.822336),
            (15.0, 35.0, 100.0, 1523.238609),
            (28.0, 12.0, 5.0, 1518.005805),
        ] {
            let found = at_pressure(t, s, bar);
            assert!((found - expected).abs() < 1e-3, "{t} {s} {bar}: {found}");
        }
    }

    #[test]
    fn what_says_two_things_is_refused() {
        let both = SoundSpeedSettings {
            m_s: Some(1480.0),
            temperature_c: Some(20.0),
            ..SoundSpeedSettings::default()
        };
        assert!(both.check().is_err());
        assert!(SoundSpeedSettings::default().check().is_ok());
        assert_eq!(SoundSpeedSettings::default().water_m_s(), None);
    }
}
