//! Counts the packets of an XTF file that are no side-scan pings.

use std::collections::BTreeMap;

/// Packets by the number of their type.
#[derive(Clone, Debug, Default)]
pub(super) struct Packets {
    counts: BTreeMap<u8, usize>,
}

impl Packets {
    /// Counts one.
    pub(super) fn count(&mut self, kind: u8) {
        *self.counts.entry(kind).or_default() += 1;
    }

    /// Returns the number of all packets.
    pub(super) fn total(&self) -> usize {
        self.counts.values().sum()
    }

    /// `120 bathymetry (type 2) and 30 attitude (type 3) packets`, most first.
    pub(super) fn summary(&self) -> String {
        let mut counts: Vec<(u8, usize)> =
            self.counts.iter().map(|(&kind, &count)| (kind, count)).collect();
        counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let each = counts.iter().map(|&(kind, count)| match name(kind) {
            Some(name) => format!("{count} {name} (type {kind})"),
            None => format!("{count} of type {kind}"),
        });
        let mut each: Vec<String> = each.collect();
        let last = each.pop().unwrap_or_default();
        if each.is_empty() {
            format!("{last} packets")
        } else {
            format!("{} and {last} packets", each.join(", "))
        }
    }
}

/// Returns the name of a type in Triton's list of packet types; vendors' own are numbers only.
fn name(kind: u8) -> Option<&'static str> {
    match kind {
        0 => Some("damaged side-scan"),
        1 => Some("note"),
        2 | 9 | 10 | 14 | 17 | 18 | 22 | 25 | 26 | 28 | 60 | 61 | 65 => Some("bathymetry"),
        3 => Some("attitude"),
        6 => Some("serial"),
        20 => Some("GPS"),
        23 | 84 => Some("gyro"),
        42 | 107 => Some("navigation"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_are_listed_by_kind_the_most_frequent_first() {
        let mut packets = Packets::default();
        packets.count(3);
        assert_eq!(packets.summary(), "1 attitude (type 3) packets");
        for kind in [2, 2, 2, 199, 199] {
            packets.count(kind);
        }
        assert_eq!(packets.total(), 6);
        assert_eq!(
            packets.summary(),
            "3 bathymetry (type 2), 2 of type 199 and 1 attitude (type 3) packets"
        );
    }
}
