//! Tests of the table of settings against serde's own lists of fields and variants.

use super::rows::{self, ROWS};
use super::{Preset, SettingKind, Settings, help, markdown, row};
use bathyscope_bottom::presentation::units::Units;
use std::collections::BTreeSet;

/// Returns the names that serde lists as expected in place of one that does not exist.
fn expected(toml: &str) -> Vec<String> {
    let error = toml::from_str::<Settings>(toml).expect_err("no such name");
    let text = error.message().to_owned();
    let list = text.split_once("expected").map_or("", |(_, list)| list);
    let names = list.split('`').skip(1).step_by(2);
    names.map(str::to_owned).collect()
}

#[test]
fn every_setting_has_a_row_and_every_row_a_setting() {
    let groups = expected("no_such_key = 1");
    let mut keys = BTreeSet::new();
    // The old name of a group is read, but has no rows.
    for group in groups.iter().filter(|group| *group != "bottom" && *group != "left_out") {
        // For an unknown key, serde lists the fields of a group; a setting without fields gives
        // another error.
        match toml::from_str::<Settings>(&format!("[{group}]\nno_such_key = 1")) {
            Err(error) if error.message().contains("unknown field") => {
                let fields = expected(&format!("[{group}]\nno_such_key = 1"));
                keys.extend(fields.iter().map(|field| format!("{group}.{field}")));
            }
            _ => {
                keys.insert(group.clone());
            }
        }
    }
    let in_table: BTreeSet<String> = ROWS.iter().map(|row| row.key.to_owned()).collect();
    assert_eq!(in_table, keys);
    assert_eq!(in_table.len(), ROWS.len(), "a key has one row");
}

#[test]
fn every_preset_lies_within_the_table() {
    for preset in [Preset::Published, Preset::Recommended] {
        assert_eq!(Settings::preset(preset).check(), Ok(()));
    }
}

#[test]
fn a_number_is_checked_at_both_ends_of_its_range() {
    for row in ROWS {
        let SettingKind::Number(number) = &row.kind else {
            continue;
        };
        let [least, most] = number.range;
        assert!(least < most && number.step > 0.0, "{}", row.key);
        let check = |value: f64| {
            let assigned = Settings::default().with_assignment(&format!("{}={value}", row.key));
            assigned.and_then(|settings| settings.check().map(|()| settings))
        };
        for end in [least, most] {
            let settings = check(end).unwrap_or_else(|error| panic!("{} {end}: {error}", row.key));
            assert_eq!((number.get)(&settings), Some(end), "{}", row.key);
        }
        // Values outside the range by one step, if the type can hold them.
        for beyond in [least - number.step, most + number.step] {
            let error = check(beyond).expect_err(row.key);
            assert!(error.0.contains(row.key), "{error}");
        }
        let mut settings = Settings::default();
        let control = number.shown_in(Units::default());
        (number.set)(&mut settings, control.in_setting(0.5 * (least + most)));
        let shown = control.value(&settings);
        assert!((shown - 0.5 * (least + most)).abs() <= 0.5, "{}", row.key);
        (number.set)(&mut settings, control.in_setting(0.0));
        if number.zero_is_none() {
            assert_eq!((number.get)(&settings), None, "{}", row.key);
        }
    }
    assert!(
        Settings::default()
            .with_assignment("isobaths.depths_m=[1.0, nan]")
            .and_then(|settings| settings.check())
            .is_err()
    );
}

#[test]
fn a_choice_has_all_names_that_its_type_has() {
    for row in ROWS {
        let SettingKind::Choice(choice) = &row.kind else {
            continue;
        };
        let names: BTreeSet<String> =
            (choice.names.iter().map(|name| name.value.to_owned())).collect();
        let toml = match row.key.split_once('.') {
            Some((group, key)) => format!("[{group}]\n{key} = \"no_such_name\""),
            None => format!("{} = \"no_such_name\"", row.key),
        };
        // A flag is not an enumeration, and a coordinate system may have any number.
        if !names.contains("true") && choice.others.is_empty() {
            let mut known: BTreeSet<String> = expected(&toml).into_iter().collect();
            if row.key == "surface.method" {
                // These names are read from older projects, but not listed anywhere.
                known.retain(|name| name != "auto" && name != "smooth");
            }
            assert_eq!(names, known, "{}", row.key);
        }
        let mut settings = Settings::default();
        for name in choice.names {
            (choice.set)(&mut settings, name.value);
            assert_eq!((choice.get)(&settings), name.value, "{}", row.key);
        }
        let before = settings.clone();
        (choice.set)(&mut settings, "no_such_name");
        assert_eq!(settings, before);
    }
}

#[test]
fn help_and_manual_hold_every_key() {
    let (help, page) = (help(), markdown());
    // The help breaks its lines, so meanings are compared word by word.
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let in_one_line = words(&help);
    for row in ROWS {
        let said = format!("\n{} = {}, ", row.key, row.values());
        assert!(help.contains(&said), "{said}");
        assert!(in_one_line.contains(&words(&row.meaning())), "{}", row.key);
        assert!(page.contains(&format!("| `{}` |", row.key)), "{}", row.key);
    }
    for line in help.lines().filter(|line| line.starts_with(' ')) {
        assert!(line.chars().count() <= 88, "{line}");
    }
    let radius = help.lines().find(|line| line.starts_with("outliers.radius_m "));
    assert_eq!(radius, Some("outliers.radius_m = 0.01 to 100 m, default 3.011"));
    assert!(help.contains("\ncloud.geometry = slope | "));
    assert!(help.contains("\n      nadir: Straight below the boat"), "{help}");
    let line = page.lines().find(|line| line.contains("`projection`"));
    let line = line.expect("a line");
    assert!(line.contains("enu \\| mercator | enu | mercator |"), "{line}");
    assert_eq!(row("draft_m").map(|row| row.label), Some(rows::DRAFT.label));
}

#[test]
fn presets_are_recognised_whatever_the_flat_spot() {
    for preset in [Preset::Published, Preset::Recommended] {
        let settings = Settings::preset(preset).with_assignment("calibration.pings=1..9").unwrap();
        assert_eq!(settings.matching_preset(), Some(preset));
    }
    assert_eq!(
        Settings::default().with_assignment("cloud.alpha2_deg=12").unwrap().matching_preset(),
        None
    );
}
