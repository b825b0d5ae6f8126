//! How far measurements of one thing scatter.

/// The value that a share of the values lies below, linear between the two around its rank; `None` of no values.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = share * (sorted.len() as f64 - 1.0).max(0.0);
    let below = *sorted.get(rank.floor() as usize)?;
    let above = sorted.get(rank.ceil() as usize)?;
    Some(below + (above - below) * rank.fract())
}

/// The value in the middle; `None` of no values.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// Half the distance between the quartiles, as a share of the median; `None` of fewer than four values.
pub fn spread(values: &[f64]) -> Option<f64> {
    if values.len() < 4 {
        return None;
    }
    let [first, middle, third] = [0.25, 0.5, 0.75].map(|share| quantile(values, share));
    Some(0.5 * (third? - first?) / middle?)
}

#[cfg(test)]
mod tests {
    use super::{median, spread};

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
        assert_eq!(
            [median(&[3.0, 9.0, 1.0]), median(&[4.0, 1.0]), median(&[])],
            [Some(3.0), Some(2.5), None]
        );
    }
}
