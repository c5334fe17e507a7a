//! What exact judges find, and whether an engine's answers are that.

use halfline::{Hit, Ray};

/// How far barycentrics may be from the exact ones: 2^-40, and two roundings.
pub const WEIGHT_TOLERANCE: f64 = 4097.0 * f64::EPSILON;

/// A contact of a line with a closed triangle, exactly known and then rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactContact {
    pub face: u32,
    /// The doubles nearest to the exact values.
    pub t: f64,
    pub u: f64,
    pub v: f64,
    /// True if the line crosses the triangle once its origin is moved by (e, e^2, e^3).
    pub is_crossing: bool,
    /// True if it is inside an edge that an odd number of faces have, or at an end of such an edge.
    pub is_on_border: bool,
}

impl ExactContact {
    /// True for a hit of the same triangle and t, to the bit; u and v to [`WEIGHT_TOLERANCE`].
    fn is(&self, hit: &Hit) -> bool {
        self.face == hit.face
            && self.t.to_bits() == hit.t.to_bits()
            && [(self.u, hit.u), (self.v, hit.v)].into_iter().all(|(exact, got)| {
                (exact - got).abs() <= WEIGHT_TOLERANCE && (0.0..=1.0).contains(&got)
            })
    }
}

/// Sorts contacts as hits are sorted: by t, and at equal t by face.
pub fn sort(contacts: &mut [ExactContact]) {
    contacts.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
}

/// A ray and all of its contacts within its range, sorted.
#[derive(Clone, Debug)]
pub struct Case {
    pub ray: Ray,
    pub contacts: Vec<ExactContact>,
}

impl Case {
    /// A ray along `line`, all of whose contacts these are, as far as `range` reaches.
    pub fn new(line: Ray, mut contacts: Vec<ExactContact>, range: Range) -> Case {
        sort(&mut contacts);
        let [t_min, t_max] = range.bounds(&contacts);
        contacts.retain(|contact| t_min <= contact.t && contact.t <= t_max);
        Case { ray: Ray { t_min, t_max, ..line }, contacts }
    }
}

/// A range of t, which may begin or end at a contact: at the one with this number, modulo how many
/// there are, if there is any.
#[derive(Clone, Copy, Debug)]
pub enum Range {
    HalfLine,
    Line,
    Fixed(f64, f64),
    At(usize),
    From(usize),
    UpTo(usize),
    After(usize),
    Before(usize),
}

impl Range {
    fn bounds(self, contacts: &[ExactContact]) -> [f64; 2] {
        let t = |i: usize| contacts.get(i % contacts.len().max(1)).map_or(0.0, |c| c.t);
        match self {
            Range::HalfLine => [0.0, f64::INFINITY],
            Range::Line => [f64::NEG_INFINITY, f64::INFINITY],
            Range::Fixed(t_min, t_max) => [t_min, t_max],
            Range::At(i) => [t(i), t(i)],
            Range::From(i) => [t(i), f64::INFINITY],
            Range::UpTo(i) => [f64::NEG_INFINITY, t(i)],
            Range::After(i) => [t(i).next_up(), f64::INFINITY],
            Range::Before(i) => [f64::NEG_INFINITY, t(i).next_down()],
        }
    }
}

/// Everything that an engine answers about a ray.
#[derive(Clone, Debug, PartialEq)]
pub struct Answers {
    pub closest: Hit,
    pub any: bool,
    pub all: Vec<Hit>,
}

impl Answers {
    /// True if they are what the contacts say: the first is the closest, any is whether there is
    /// one, and all hits are those that [`expected_hits`] gives.
    pub fn are_right(&self, contacts: &[ExactContact]) -> bool {
        let closest_is_right = match contacts.first() {
            Some(first) => first.is(&self.closest),
            None => self.closest == Hit::MISS,
        };
        let expected = expected_hits(contacts);
        closest_is_right
            && self.any != contacts.is_empty()
            && self.all.len() == expected.len()
            && expected.iter().zip(&self.all).all(|(expected, hit)| expected.is(hit))
    }
}

/// All hits among sorted contacts: at each t the crossings, or, if there is none but the border is
/// met, the contact with the lowest face.
fn expected_hits(contacts: &[ExactContact]) -> Vec<&ExactContact> {
    let mut expected = Vec::new();
    for at_one_t in contacts.chunk_by(|a, b| a.t == b.t) {
        if at_one_t.iter().any(|c| c.is_crossing) {
            expected.extend(at_one_t.iter().filter(|c| c.is_crossing));
        } else if at_one_t.iter().any(|c| c.is_on_border) {
            expected.push(&at_one_t[0]);
        }
    }
    expected
}
