//! How far measurements of one thing scatter.

/// Half the distance between the quartiles, as a share of the median; `None` of fewer than four values.
pub fn spread(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    // Linear between the two values around the rank.
    let quantile = |share: f64| {
        let rank = share * (sorted.len() - 1) as f64;
        let below = rank.floor() as usize;
        let above = (below + 1).min(sorted.len() - 1);
        sorted[below] + (sorted[above] - sorted[below]) * rank.fract()
    };
    (sorted.len() >= 4).then(|| 0.5 * (quantile(0.75) - quantile(0.25)) / quantile(0.5))
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn the_quartiles_are_those_of_the_sorted_values() {
        // Quartiles 2 and 4 around 3.
        assert_eq!(spread(&[5.0, 1.0, 4.0, 2.0, 3.0]), Some(1.0 / 3.0));
        // Quartiles 1.75 and 3.25 around 2.5.
        assert_eq!(spread(&[1.0, 2.0, 3.0, 4.0]), Some(0.3));
        assert_eq!(spread(&[7.0; 9]), Some(0.0));
        // One frame that was disturbed changes nothing.
        assert_eq!(spread(&[2.0, 2.0, 2.0, 2.0, 9.0]), Some(0.0));
        assert_eq!(spread(&[1.0, 2.0, 3.0]), None);
    }
}
