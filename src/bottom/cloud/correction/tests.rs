use super::*;
use bathyscope_log::survey::{MountingSettings, Sounding};

fn survey(start_unix_s: Option<f64>) -> Survey {
    let sounding = |time_s| Sounding::new(time_s, 3.0);
    Survey {
        start_unix_s,
        soundings: vec![sounding(0.0), sounding(1800.0)].into(),
        ..Survey::default()
    }
}

/// 1.5 m rising to 2.5 m within an hour.
fn readings() -> WaterLevelSettings {
    let gauge = Gauge {
        path: "gauge.csv".into(),
        readings: vec![(1_634_000_000.0, 1.5), (1_634_003_600.0, 2.5)],
        ..Gauge::default()
    };
    WaterLevelSettings { file: Some(gauge.path.clone()), gauge: Some(Arc::new(gauge)) }
}

#[test]
fn everything_at_once_is_the_sum_of_its_parts() {
    let settings = DepthSettings {
        draft_m: 0.4,
        water_level_m: 100.0,
        water_level: readings(),
        sound_speed: SoundSpeedSettings { m_s: Some(1485.0), ..SoundSpeedSettings::default() },
        height_offset_m: -0.07,
    };
    let made = Correction::new(settings, &survey(Some(1_634_000_000.0)));
    assert_eq!(made.refused, None);
    // 3 m at 0.99 of the speed, 0.4 m deeper, and the water half an hour later 102 m above the
    // level.
    let depth_m = made.depth_m(1800.0, 3.0);
    assert!((depth_m - (3.0 * 0.99 + 0.4 - 102.0 + 0.07)).abs() < 1e-9, "{depth_m}");
    assert!((made.middle_level_m - 101.75).abs() < 1e-9);
    let said = made.statement();
    for words in [
        "1485.0 m/s",
        "times 0.99000",
        "draft 0.4 m",
        "gauge.csv",
        "100 m",
        "height offset -0.07 m",
        "Not corrected: roll and pitch.",
    ] {
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn readings_that_are_hours_apart_are_not_bridged_without_a_word() {
    let with = |readings: Vec<(f64, f64)>| {
        let gauge = Gauge { path: "gauge.csv".into(), readings, ..Gauge::default() };
        let water_level =
            WaterLevelSettings { file: Some(gauge.path.clone()), gauge: Some(Arc::new(gauge)) };
        let settings = DepthSettings { water_level, ..DepthSettings::default() };
        Correction::new(settings, &survey(Some(1_634_000_000.0)))
    };
    let (before_s, after_s) = (1_633_990_000.0, 1_634_012_000.0);
    let far = with(vec![(before_s, 1.0), (after_s, 3.0)]);
    let said = far.gap_warning().expect("a warning");
    assert!(said.contains("from 1 m to 3 m") && said.contains("deviation of 0.50 m"), "{said}");
    assert_eq!(far.gap_sigma_m(), 0.5);
    let level = with(vec![(before_s, 1.0), (after_s, 1.01)]);
    assert_eq!((level.gap_warning(), level.gap_sigma_m()), (None, 0.0));
    let close = with(vec![(before_s, 0.0), (1_633_999_900.0, 1.5), (1_634_003_500.0, 2.5)]);
    assert_eq!(close.gap_warning(), None);
}

#[test]
fn nothing_known_changes_nothing_and_says_so() {
    let made = Correction::new(DepthSettings::default(), &survey(None));
    assert_eq!(made.depth_m(7.0, 2.25), 2.25);
    assert_eq!(
        made.statement(),
        "Depths are below the transducer. Applied: nothing. Not corrected: draft, water level or tide, sound speed, roll and pitch."
    );
}

#[test]
fn a_clock_that_is_wrong_takes_the_reading_of_another_time_until_it_is_put_right() {
    // The water rises 1 m an hour. A recorder whose clock is 6 minutes behind takes readings that
    // are 10 cm too low.
    let behind = survey(Some(1_634_000_000.0));
    let with = |clock_offset_s| {
        let settings = DepthSettings { water_level: readings(), ..DepthSettings::default() };
        let mounting = MountingSettings { clock_offset_s, ..MountingSettings::default() };
        Correction::new(settings, &behind.clone().mounted(&mounting))
    };
    let [wrong, right] = [with(0.0), with(360.0)];
    for time_s in [0.0, 900.0, 1800.0] {
        let off_m = wrong.depth_m(time_s, 3.0) - right.depth_m(time_s, 3.0);
        assert!((off_m - 0.1).abs() < 1e-9, "{time_s}: {off_m}");
    }
    assert!(right.statement().contains("360 s later"), "{}", right.statement());
    // Put an hour ahead, the log ends after the last reading.
    assert!(with(3600.0).refused.is_some());
}

#[test]
fn readings_that_do_not_cover_the_log_are_refused() {
    let with = |start_unix_s| {
        let settings = DepthSettings { water_level: readings(), ..DepthSettings::default() };
        Correction::new(settings, &survey(start_unix_s))
    };
    let late = with(Some(1_634_002_000.0));
    let why = late.refused.as_ref().expect("a reason").to_string();
    assert!(why.contains("01:53:20") && why.contains("01:56:40"), "{why}");
    // Nothing is corrected by half.
    assert_eq!(late.depth_m(0.0, 3.0), 3.0);
    assert!(late.statement().contains("Not corrected: draft, water level"));
    assert!(with(Some(1_633_999_999.0)).refused.is_some());
    assert!(with(None).refused.expect("a reason").to_string().contains("does not know the time"));
}

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
