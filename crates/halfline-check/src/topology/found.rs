//! A count of defects, and the first faces that have them.

/// How many faces are kept as examples.
const EXAMPLES: usize = 5;

/// How often a defect was found, and where first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// How often the defect was found.
    pub count: usize,
    /// The lowest indices, at most five, of triangles that have the defect; rising.
    pub first_faces: Vec<u32>,
}

impl Found {
    /// Counts one defect, of `face`.
    pub(super) fn add(&mut self, face: u32) {
        self.count += 1;
        self.show(face);
    }

    /// The defects of both.
    pub(super) fn and(mut self, other: Found) -> Found {
        self.count += other.count;
        other.first_faces.into_iter().for_each(|face| self.show(face));
        self
    }

    /// Makes `face` one of the examples if it is low enough.
    fn show(&mut self, face: u32) {
        if let Err(place) = self.first_faces.binary_search(&face)
            && place < EXAMPLES
        {
            self.first_faces.truncate(EXAMPLES - 1);
            self.first_faces.insert(place, face);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Found;

    #[test]
    fn the_lowest_faces_are_shown_once_each() {
        let mut found = Found::default();
        [9, 4, 4, 7, 1, 8, 2].into_iter().for_each(|face| found.add(face));
        assert_eq!(found, Found { count: 7, first_faces: vec![1, 2, 4, 7, 8] });
        let mut other = Found::default();
        [0, 3, 9].into_iter().for_each(|face| other.add(face));
        assert_eq!(found.and(other), Found { count: 10, first_faces: vec![0, 1, 2, 3, 4] });
    }
}
