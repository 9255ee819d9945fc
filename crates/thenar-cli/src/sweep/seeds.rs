//! Seeds: those that a scene states, and those that they are set to.

use crate::error::CliError;
use thenar_input::quoted;
use toml::Value;

/// Most seeds.
const SEEDS_MAX: u32 = 1_000_000;

/// Reads `1,2,5` or `1..10`, both ends in it.
///
/// # Errors
/// A seed is not a whole number from 0, or there twice; the range is empty or too long.
pub fn parse(text: &str) -> Result<Vec<u32>, CliError> {
    let wrong = |what: &str| CliError::Input(format!("--seeds {}: {what}", quoted(text)));
    let form = "expected whole numbers from 0, as 1,2,5 or 1..10";
    let number = |text: &str| text.trim().parse::<u32>().map_err(|_| wrong(form));
    if let Some((first, last)) = text.split_once("..") {
        let (first, last) = (number(first)?, number(last)?);
        if last < first || last - first >= SEEDS_MAX {
            return Err(wrong("the range must have 1 to 1000000 seeds"));
        }
        return Ok((first..=last).collect());
    }
    let seeds = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    for (i, seed) in seeds.iter().enumerate() {
        if seeds[..i].contains(seed) {
            return Err(wrong(&format!("the seed {seed} is there twice")));
        }
    }
    Ok(seeds)
}

/// Keys of all seeds that a scene states.
///
/// # Errors
/// There is none.
pub fn keys(text: &str) -> Result<Vec<String>, CliError> {
    let mut found = Vec::new();
    if let Ok(root) = text.parse::<toml::Table>() {
        root.iter().for_each(|(key, value)| find(key, key, value, &mut found));
    }
    match found.is_empty() {
        true => Err(CliError::Input("--seeds: the scene states no `seed`".into())),
        false => Ok(found),
    }
}

fn find(path: &str, key: &str, value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Integer(_) if key == "seed" => found.push(path.into()),
        Value::Table(table) => {
            table.iter().for_each(|(key, v)| find(&format!("{path}.{key}"), key, v, found));
        }
        Value::Array(elements) => {
            let all = elements.iter().enumerate();
            all.for_each(|(i, v)| find(&format!("{path}.{i}"), "", v, found));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_ranges() {
        assert_eq!(parse("3, 1").unwrap(), [3, 1]);
        assert_eq!(parse("2..4").unwrap(), [2, 3, 4]);
        for bad in ["", "a", "1,1", "-1", "4..2", "0..1000000", "1.5"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn seeds_are_found_wherever_they_are() {
        let text = "[a]\nseed = 1\n[[soft]]\nname = \"x\"\n[[soft]]\nshape = { seed = 2, n = 3 }\n";
        assert_eq!(keys(text).unwrap(), ["a.seed", "soft.1.shape.seed"]);
        assert!(keys("a = 1").is_err());
    }
}
