//! The directed vectors are met by a model that was written from the contract alone, and they find every mistake that it
//! can be made to make.

use slicecast_host_tests::found::{departures, mutations, table};
use slicecast_vectors::directed;

#[test]
fn the_second_model_meets_every_directed_vector() {
    let mut wrong = Vec::new();
    for set in directed::sets() {
        let departures = departures(&set, None);
        if let Some(first) = departures.first() {
            wrong.push((set.name.clone(), departures.len(), *first));
        }
    }
    assert!(wrong.is_empty(), "set, how many, first: {wrong:?}");
}

#[test]
fn directed_vectors_find_every_mistake() {
    let found = mutations();
    let missed: Vec<_> = found
        .iter()
        .filter(|found| found.vectors == 0)
        .map(|found| found.mistake)
        .collect();
    assert!(missed.is_empty(), "not found: {missed:?}");
    assert!(found.len() >= 90, "{}", found.len());
    assert_eq!(table(&found).lines().count(), found.len() + 2);
}
