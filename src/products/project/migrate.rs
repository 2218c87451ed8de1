//! Older projects: what each version changed, step by step.

use super::row::Rows;

/// The version that is written.
pub(super) const VERSION: u32 = 1;

/// Makes rows of one version those of the next.
type Step = fn(Rows) -> Rows;

/// Steps from each version to the next, that from 1 to 2 first: one step less than there are
/// versions. Each version has a file in the tests that opens for ever.
const STEPS: [Step; VERSION as usize - 1] = [];

/// Rows of one version as those of a later one.
pub(super) fn migrate(rows: Rows, from: u32, to: u32) -> Rows {
    through(&STEPS, rows, from, to)
}

fn through(steps: &[Step], rows: Rows, from: u32, to: u32) -> Rows {
    let steps = (from..to).filter_map(|version| steps.get(version as usize - 1));
    steps.fold(rows, |rows, step| step(rows))
}

#[cfg(test)]
mod tests {
    use super::super::row::{Key, Row};
    use super::*;
    use toml::Value;

    fn renamed(rows: Rows, from: &str, to: &str) -> Rows {
        let rename = |(key, row): (Key, Row)| {
            let key = if key.to_string() == from {
                Key::new(Key::parse(to).expect("a key"))
            } else {
                key
            };
            (key, row)
        };
        rows.into_iter().map(rename).collect()
    }

    #[test]
    fn each_version_takes_the_steps_that_it_lacks_in_their_order() {
        let steps: [Step; 2] = [
            |rows| renamed(rows, "settings.a", "settings.b"),
            |rows| renamed(rows, "settings.b", "settings.c"),
        ];
        for (from, to, name, expected) in [
            (1, 3, "a", "c"),
            (1, 2, "a", "b"),
            (2, 3, "b", "c"),
            (3, 3, "a", "a"),
            (2, 3, "a", "a"),
        ] {
            let key = Key::new(["settings", name]);
            let rows = Rows::from([(key, Row::new(&Value::Integer(7)))]);
            let after = through(&steps, rows, from, to);
            let keys: Vec<String> = after.keys().map(Key::to_string).collect();
            assert_eq!(keys, [format!("settings.{expected}")], "{from} to {to}");
        }
    }
}
