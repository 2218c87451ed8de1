//! Writes small NMEA logs for tests, sentence by sentence as `mod.rs` describes them.

/// Options of a generated log.
#[derive(Clone, Debug)]
pub struct NmeaOptions {
    /// Seconds that it lasts; a position comes each second.
    pub seconds: usize,
    /// Seconds since midnight when it begins.
    pub begins_s: f64,
    /// Date of the first day, `ddmmyy`; `None` writes GGA in place of RMC.
    pub date: Option<&'static str>,
    /// Depths a second.
    pub depths: usize,
    /// Sentence that a depth is written as: `DPT`, `DBT`, or `DBT` in feet only.
    pub depth_in: DepthIn,
    /// Second field of DPT, metres.
    pub offset_m: f64,
    /// Heading, degrees, and the type that it is written as: `HDT`, `HDG`, `HDM`.
    pub heading: Option<(f64, &'static str)>,
    /// Text before each sentence.
    pub stamp: Stamp,
}

/// Sentence that a depth is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthIn {
    /// DPT, metres.
    Dpt,
    /// DBT, all units.
    Dbt,
    /// DBT, feet only.
    Feet,
}

/// Text that the logger writes before each sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamp {
    /// Nothing.
    None,
    /// A tag block with Unix milliseconds.
    Tag,
    /// The time of day, of a clock that is 90 s ahead.
    Clock,
}

impl Default for NmeaOptions {
    fn default() -> Self {
        Self {
            seconds: 20,
            begins_s: 36_000.0,
            date: Some("040326"),
            depths: 2,
            depth_in: DepthIn::Dpt,
            offset_m: 0.0,
            heading: None,
            stamp: Stamp::None,
        }
    }
}

/// `date -u -d "2026-03-04" +%s`.
pub const MIDNIGHT_S: f64 = 1_772_582_400.0;

/// A sentence with its sum, and the end of the line.
pub fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

/// Depth of a sounding, metres.
pub fn depth_m(index: usize) -> f64 {
    2.0 + (index % 50) as f64 / 10.0
}

/// Minutes north of 48 degrees at a second of the log.
pub fn minutes(second: usize) -> f64 {
    7.038 + second as f64 * 1e-3
}

/// A whole log.
pub fn nmea(options: &NmeaOptions) -> Vec<u8> {
    let mut text = String::new();
    let line = |at_s: f64, body: String| stamp(options, at_s) + &sentence(&body);
    for second in 0..options.seconds {
        let mut add = |at_s: f64, body: String| text += &line(at_s, body);
        let at_s = options.begins_s + second as f64;
        let minutes = minutes(second);
        let time = time_of_day(at_s);
        match options.date {
            Some(date) if at_s < 86_400.0 => add(
                at_s,
                format!(
                    "GPRMC,{time},A,48{minutes:07.4},N,01131.0000,W,005.0,084.4,{date},003.1,W,A"
                ),
            ),
            Some(_) => add(
                at_s,
                format!(
                    "GPRMC,{time},A,48{minutes:07.4},N,01131.0000,W,005.0,084.4,050326,003.1,W,A"
                ),
            ),
            None => {
                add(
                    at_s,
                    format!("GPGGA,{time},48{minutes:07.4},N,01131.0000,W,1,08,0.9,5.4,M,46.9,M,,"),
                );
                add(at_s, "GPVTG,084.4,T,087.5,M,005.0,N,009.3,K".to_owned());
            }
        }
        match options.heading {
            Some((degrees, "HDT")) => add(at_s, format!("HEHDT,{degrees:.1},T")),
            Some((degrees, "HDG")) => add(at_s, format!("HCHDG,{degrees:.1},1.0,E,2.0,W")),
            Some((degrees, kind)) => add(at_s, format!("HC{kind},{degrees:.1},M")),
            None => {}
        }
        for depth in 0..options.depths {
            let after_s = (depth as f64 + 0.25) / options.depths as f64;
            let metres = depth_m(second * options.depths + depth);
            add(at_s + after_s, depth_body(options, metres));
        }
        text += "!AIVDM,1,1,,A,13u?etPv2;0n:dDPwUM1U1Cb069D,0*24\r\n";
        text += &sentence("GPGSV,3,1,11,03,03,111,00,04,15,270,00,06,01,010,00,13,06,292,00");
    }
    text.into_bytes()
}

fn depth_body(options: &NmeaOptions, metres: f64) -> String {
    let (feet, fathoms) = (metres / 0.3048, metres / 1.8288);
    match options.depth_in {
        DepthIn::Dpt => format!("SDDPT,{metres:.2},{:.2}", options.offset_m),
        DepthIn::Dbt => format!("SDDBT,{feet:.1},f,{metres:.2},M,{fathoms:.1},F"),
        DepthIn::Feet => format!("SDDBT,{feet:.3},f,,M,,F"),
    }
}

fn stamp(options: &NmeaOptions, at_s: f64) -> String {
    match options.stamp {
        Stamp::None => String::new(),
        Stamp::Tag => {
            let tag = format!("s:sounder,c:{:.0}", (MIDNIGHT_S + at_s) * 1e3);
            let sum = tag.bytes().fold(0, |sum, byte| sum ^ byte);
            format!("\\{tag}*{sum:02X}\\")
        }
        Stamp::Clock => {
            let at_s = (at_s + 90.0) % 86_400.0;
            let [hours, minutes] = [at_s / 3600.0, at_s / 60.0 % 60.0].map(f64::trunc);
            format!("[{hours:02}:{minutes:02}:{:06.3}] ", at_s % 60.0)
        }
    }
}

fn time_of_day(at_s: f64) -> String {
    let at_s = at_s % 86_400.0;
    let [hours, minutes] = [at_s / 3600.0, at_s / 60.0 % 60.0].map(f64::trunc);
    format!("{hours:02}{minutes:02}{:05.2}", at_s % 60.0)
}
