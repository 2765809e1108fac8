//! Which of many things belong together, when pairs of them are joined one after another?
//!
//! Each group is known by its first member, the one with the smallest number, whatever the order in which pairs are joined.
//! Source: Galler & Fischer 1964 (trees that point to their root); path halving after Tarjan & van Leeuwen 1984.
//! Pitfall: the root is always the first member, so trees may grow deeper than with joins by rank; halving makes up for it:
//! a million joins and looks cost some hundredths of a second.

/// Groups of the things 0, 1, 2, …, up to 2³² − 1 of them.
#[derive(Debug, Clone, Default)]
pub struct Groups {
    /// An earlier member of the same group; the first points to itself.
    earlier: Vec<u32>,
}

impl Groups {
    /// Each of `count` things alone. What lies beyond 2³² − 1 is never joined.
    pub fn new(count: usize) -> Self {
        Self { earlier: (0..u32::try_from(count).unwrap_or(u32::MAX)).collect() }
    }

    /// One thing more, alone; its number.
    pub fn push(&mut self) -> usize {
        let count = self.earlier.len();
        self.earlier.extend(u32::try_from(count).ok().filter(|number| *number < u32::MAX));
        count
    }

    /// How many things there are.
    pub fn len(&self) -> usize {
        self.earlier.len()
    }

    /// Whether there is nothing to group.
    pub fn is_empty(&self) -> bool {
        self.earlier.is_empty()
    }

    /// The first member of a thing's group: the thing itself if it is alone, or not known at all.
    pub fn first(&mut self, thing: usize) -> usize {
        let mut at = thing;
        while let Some(before) = self.before(at).filter(|before| *before != at) {
            // Halves the way for those who come after.
            let farther = self.before(before).unwrap_or(before);
            self.point(at, farther);
            at = farther;
        }
        at
    }

    /// Makes one group of two; its first member. Nothing happens if one of the things is not known.
    pub fn join(&mut self, a: usize, b: usize) -> usize {
        let (a, b) = (self.first(a), self.first(b));
        let (keeps, goes) = (a.min(b), a.max(b));
        self.point(goes, keeps);
        keeps
    }

    fn before(&self, at: usize) -> Option<usize> {
        self.earlier.get(at).map(|before| *before as usize)
    }

    fn point(&mut self, at: usize, to: usize) {
        if let (Some(slot), Ok(to)) = (self.earlier.get_mut(at), u32::try_from(to)) {
            *slot = to;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The smallest number that a thing's own can be turned into by the pairs, found by trying all of them over and over.
    fn closure(count: usize, pairs: &[(usize, usize)]) -> Vec<usize> {
        let mut first: Vec<usize> = (0..count).collect();
        for _ in 0..count {
            for (a, b) in pairs {
                let least = first[*a].min(first[*b]);
                (first[*a], first[*b]) = (least, least);
            }
        }
        first
    }

    proptest! {
        #[test]
        fn groups_are_what_pairs_tie_together_and_their_first_member_stands_for_them(
            (count, late, pairs) in (1usize..40, 0usize..10).prop_flat_map(|(count, late)| {
                (Just(count), Just(late), prop::collection::vec((0..count + late, 0..count + late), 0..60))
            })
        ) {
            let mut groups = Groups::new(count);
            for n in 0..late {
                prop_assert_eq!(groups.push(), count + n);
            }
            prop_assert_eq!(groups.len(), count + late);
            for (a, b) in &pairs {
                let first = groups.join(*a, *b);
                prop_assert_eq!((first, first), (groups.first(*a), groups.first(*b)));
            }
            let found: Vec<usize> = (0..count + late).map(|thing| groups.first(thing)).collect();
            prop_assert_eq!(found, closure(count + late, &pairs));
        }
    }

    #[test]
    fn what_is_not_known_stays_alone() {
        let mut groups = Groups::new(2);
        groups.join(1, 7);
        assert_eq!((groups.first(0), groups.first(1), groups.first(7)), (0, 1, 7));
        assert!(Groups::new(0).is_empty() && !groups.is_empty());
        groups.join(0, 1);
        assert_eq!(groups.first(1), 0, "things that are known can still be joined");
    }
}
