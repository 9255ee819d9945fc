//! A share of a sweep.

use std::ops::Range;
use std::str::FromStr;

/// The `number`-th, from 1, of `count` shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    pub number: u64,
    pub count: u64,
}

/// Most shares: a share for each atom of a cluster, and no overflow.
const COUNT_MAX: u64 = 1_000_000_000;

impl Shard {
    /// The cases: every `count`-th, so that neighbours in a grid, which take about as long, are
    /// shared evenly.
    pub fn cases(self, total: u64) -> impl Iterator<Item = u64> + Clone {
        let Range { start, end } = self.number - 1..total;
        (start..end).step_by(usize::try_from(self.count).unwrap_or(usize::MAX))
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || format!("expected K/N, e.g. 2/8, got `{text}`");
        let (number, count) = text.split_once('/').ok_or_else(form)?;
        let [number, count] = [number, count].map(|part| part.trim().parse::<u64>());
        let (number, count) = (number.map_err(|_| form())?, count.map_err(|_| form())?);
        if count == 0 || count > COUNT_MAX {
            return Err(format!("N must be from 1 to {COUNT_MAX}, got {count}"));
        }
        if number == 0 || number > count {
            return Err(format!("K must be from 1 to N, got {number} of {count}"));
        }
        Ok(Self { number, count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_all_cases_and_none_twice() {
        for total in 0..20 {
            for count in 1..25 {
                let of = |number| Shard { number, count }.cases(total);
                let mut all: Vec<u64> = (1..=count).flat_map(of).collect();
                all.sort();
                assert_eq!(all, (0..total).collect::<Vec<_>>(), "{total} in {count}");
                let sizes = (1..=count).map(|k| of(k).count());
                assert!(sizes.clone().max().unwrap() - sizes.min().unwrap() <= 1);
            }
        }
    }

    #[test]
    fn what_is_no_shard_is_refused() {
        assert_eq!("2/8".parse(), Ok(Shard { number: 2, count: 8 }));
        for (text, told) in [
            ("3", "K/N"),
            ("a/2", "K/N"),
            ("-1/2", "K/N"),
            ("3/2", "got 3 of 2"),
            ("0/2", "got 0 of 2"),
            ("1/0", "N must be"),
        ] {
            let error = text.parse::<Shard>().unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
