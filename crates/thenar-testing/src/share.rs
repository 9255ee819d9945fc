/// The request of the environment variable `THENAR_CASES` to tests with many cases: `all`, or,
/// where cases have names, those whose names contain the text. Without it they run a fixed share.
pub fn cases_wanted() -> Option<String> {
    std::env::var("THENAR_CASES").ok()
}

/// A fixed share of `cases`: the first of every `of`, in their order; all of them if `THENAR_CASES`
/// is `all`. Of a product of two lists, an `of` coprime to both lengths meets every value of each,
/// if it leaves as many cases as the longer has values.
///
/// # Panics
/// `of` is 0.
pub fn one_in<T>(of: usize, cases: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
    let all = cases_wanted().is_some_and(|wanted| wanted == "all");
    cases.into_iter().step_by(if all { 1 } else { of })
}

#[cfg(test)]
mod tests {
    use super::one_in;
    use std::collections::BTreeSet;

    #[test]
    fn a_coprime_share_of_a_product_meets_all_values() {
        let product = (0..4).flat_map(|a| (0..5).map(move |b| (a, b)));
        let some: Vec<(i32, i32)> = one_in(3, product).collect();
        assert!(some.len() == 7 || some.len() == 20, "{some:?}");
        assert_eq!(some.iter().map(|case| case.0).collect::<BTreeSet<_>>(), (0..4).collect());
        assert_eq!(some.iter().map(|case| case.1).collect::<BTreeSet<_>>(), (0..5).collect());
    }
}
