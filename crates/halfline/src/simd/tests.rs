//! Every instruction set does the same.

use super::*;

struct Push {
    near: [f32; LANES],
    far: [f32; LANES],
    words: [u32; LANES],
    lanes: u32,
}

impl Job for &Push {
    type Output = Vec<(f32, u32)>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<(f32, u32)> {
        let (mut nears, mut kept) = ([f32::NAN; LANES], [u32::MAX; LANES]);
        let (near, far) = (simd.load(&self.near), simd.load(&self.far));
        let count = simd.compress(near, far, &self.words, self.lanes, &mut nears, &mut kept);
        nears.into_iter().zip(kept).take(count).collect()
    }
}

#[test]
fn every_set_keeps_the_lanes_that_are_met_and_in_their_order() {
    let orders = [[0, 1, 2, 3, 4, 5, 6, 7], [7, 6, 5, 4, 3, 2, 1, 0], [3, 1, 4, 0, 5, 2, 6, 7]];
    for (mask, order) in (0..256u32).flat_map(|mask| orders.map(|order| (mask, order))) {
        let near: [f32; LANES] = std::array::from_fn(|lane| lane as f32 * 0.5 - 1.0);
        let far = std::array::from_fn(|lane| match (mask >> lane & 1, lane % 3) {
            (0, 0) => f32::NEG_INFINITY,
            (0, _) => near[lane].next_down(),
            (_, 0) => near[lane],
            _ => f32::INFINITY,
        });
        let words = std::array::from_fn(|lane| 100 + lane as u32);
        let lanes = order.iter().rev().fold(0, |bits, lane| bits << 3 | lane);
        let expected: Vec<(f32, u32)> = order
            .iter()
            .map(|&lane| lane as usize)
            .filter(|&lane| mask >> lane & 1 == 1)
            .map(|lane| (near[lane], words[lane]))
            .collect();
        let job = Push { near, far, words, lanes };
        for level in Level::available() {
            assert_eq!(level.run(&job), expected, "{} {mask:b} {order:?}", level.name());
        }
    }
}

struct Arithmetic([[f32; LANES]; 3]);

impl Job for &Arithmetic {
    type Output = ([[f32; LANES]; 10], u32);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let [a, b, c] = [simd.load(&self.0[0]), simd.load(&self.0[1]), simd.load(&self.0[2])];
        let read = |floats| {
            let mut lanes = [0.0; LANES];
            simd.store(floats, &mut lanes);
            lanes
        };
        let results = [
            read(simd.mul_add(a, b, c)),
            read(simd.min(a, b)),
            read(simd.max(a, b)),
            read(simd.sub(a, b)),
            read(simd.add(a, b)),
            read(simd.mul(a, b)),
            read(simd.neg_mul_add(a, b, c)),
            read(simd.abs(a)),
            read(simd.div(a, b)),
            read(simd.sqrt(simd.abs(a))),
        ];
        (results, simd.lt(a, b))
    }
}

#[test]
fn every_set_computes_lane_by_lane() {
    let (mut a, mut b, mut c) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        (a[lane], b[lane], c[lane]) = (lane as f32 - 3.0, 2.5 - lane as f32, lane as f32 * 4.0);
    }
    let expected = [
        std::array::from_fn(|lane| a[lane] * b[lane] + c[lane]),
        std::array::from_fn(|lane| a[lane].min(b[lane])),
        std::array::from_fn(|lane| a[lane].max(b[lane])),
        std::array::from_fn(|lane| a[lane] - b[lane]),
        std::array::from_fn(|lane| a[lane] + b[lane]),
        std::array::from_fn(|lane| a[lane] * b[lane]),
        std::array::from_fn(|lane| c[lane] - a[lane] * b[lane]),
        std::array::from_fn(|lane| a[lane].abs()),
        std::array::from_fn(|lane| a[lane] / b[lane]),
        std::array::from_fn(|lane| a[lane].abs().sqrt()),
    ];
    let below = (0..LANES).fold(0, |bits, lane| bits | u32::from(a[lane] < b[lane]) << lane);
    for level in Level::available() {
        assert_eq!(level.run(&Arithmetic([a, b, c])), (expected, below), "{}", level.name());
    }
}

/// Errors of products, and roots.
struct DoubleArithmetic([[f64; LANES]; 2]);

impl Job for &DoubleArithmetic {
    type Output = [[u64; LANES]; 2];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let wide = simd.doubles();
        let (a, b) = (wide.set(self.0[0]), wide.set(self.0[1]));
        let mut found = [[0.0; LANES]; 2];
        wide.store(wide.product_error(a, b, wide.mul(a, b)), &mut found[0]);
        wide.store(wide.sqrt(wide.abs(a)), &mut found[1]);
        found.map(|lanes| lanes.map(f64::to_bits))
    }
}

#[test]
fn every_set_knows_what_products_lose() {
    let mut state = 1u64;
    let mut double = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // Between 2^-200 and 2^200, of either sign.
        f64::from_bits(state & !(0x7ff << 52) | (823 + (state >> 12) % 400) << 52)
    };
    for _ in 0..1000 {
        let [a, b] = [(); 2].map(|()| std::array::from_fn(|_| double()));
        // Plus zero where nothing is lost, as a difference of equal numbers is.
        let error = |lane: usize| a[lane].mul_add(b[lane], -(a[lane] * b[lane])).to_bits();
        let root = |lane: usize| a[lane].abs().sqrt().to_bits();
        let expected = [std::array::from_fn(error), std::array::from_fn(root)];
        for level in Level::available() {
            assert_eq!(level.run(&DoubleArithmetic([a, b])), expected, "{}", level.name());
        }
    }
}

/// F64x8, and what may be chosen by comparing them; masks of lanes.
struct Choices {
    floats: [[f32; LANES]; 4],
    doubles: [[f64; LANES]; 4],
    mask: u32,
}

impl Job for &Choices {
    type Output = ([[u32; LANES]; 2], [[u64; LANES]; 2]);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let mut floats = [simd.splat(0.0); 4];
        let wide = simd.doubles();
        let mut doubles = [wide.splat(0.0); 4];
        for number in 0..4 {
            floats[number] = simd.load(&self.floats[number]);
            doubles[number] = wide.set(self.doubles[number]);
        }
        let [a, b, x, y] = floats;
        let mut singles = [[0.0; LANES]; 2];
        simd.store(simd.select_lt(a, b, x, y), &mut singles[0]);
        simd.store(simd.select(self.mask, x, y), &mut singles[1]);
        let [a, b, x, y] = doubles;
        let mut wides = [[0.0; LANES]; 2];
        wide.store(wide.select_lt(a, b, x, y), &mut wides[0]);
        wide.store(simd.widen(floats[2]), &mut wides[1]);
        (singles.map(|lanes| lanes.map(f32::to_bits)), wides.map(|lanes| lanes.map(f64::to_bits)))
    }
}

/// F64x8 that are hard to compare, or to convert.
const HARD: [f32; LANES] =
    [f32::NAN, 0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, 1e-45, -1.5, f32::MAX];

#[test]
fn every_set_chooses_lane_by_lane() {
    let y = std::array::from_fn(|lane| 7.25 - lane as f32);
    for turn in 0..LANES {
        // Against itself, and against all others.
        let (a, b) = (HARD, std::array::from_fn(|lane| HARD[(lane + turn) % LANES]));
        let floats = [a, b, HARD, y];
        let mask = 0b1011_0010 << turn & 0xff | turn as u32;
        let below = |lane: usize| a[lane] < b[lane];
        let by_mask = |lane: usize| mask >> lane & 1 == 1;
        let either = |first: bool, lane: usize| if first { HARD[lane] } else { y[lane] };
        let singles = [
            std::array::from_fn(|lane| either(below(lane), lane).to_bits()),
            std::array::from_fn(|lane| either(by_mask(lane), lane).to_bits()),
        ];
        let wides = [
            std::array::from_fn(|lane| f64::from(either(below(lane), lane)).to_bits()),
            HARD.map(|x| f64::from(x).to_bits()),
        ];
        let doubles = floats.map(|lanes| lanes.map(f64::from));
        for level in Level::available() {
            let chosen = level.run(&Choices { floats, doubles, mask });
            assert_eq!(chosen, (singles, wides), "{}, {mask:b}, {b:?}", level.name());
        }
    }
}

/// Words that are looked at and set.
struct Words {
    all: [u32; WORDS],
    eight: [u32; LANES],
    word: u32,
    mask: u32,
}

impl Job for &Words {
    type Output = (u32, u32, [u32; LANES]);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let mut set = self.eight;
        simd.masked_fill_u32(self.mask, self.word, &mut set);
        let below = simd.lt_u32(&self.all, self.word);
        (simd.eq_u32(&self.eight, self.word), below, set)
    }
}

#[test]
fn every_set_compares_and_sets_words() {
    // Without a sign: the largest word is above all others.
    let values = [0, 1, 2, 0x7fff_ffff, 0x8000_0000, 0x8000_0001, u32::MAX - 1, u32::MAX];
    let all = std::array::from_fn(|i| values[(i * 5 + i / LANES) % LANES]);
    for mask in 0..256u32 {
        let word = values[mask as usize % LANES];
        let eight = std::array::from_fn(|lane| values[(lane * mask as usize / 8) % LANES]);
        let bits = |words: &[u32], is: fn(u32, u32) -> bool| {
            words.iter().rev().fold(0, |bits, &other| bits << 1 | u32::from(is(other, word)))
        };
        let expected = (
            bits(&eight, |other, word| other == word),
            bits(&all, |other, word| other < word),
            std::array::from_fn(|lane| if mask >> lane & 1 == 1 { word } else { eight[lane] }),
        );
        for level in Level::available() {
            let found = level.run(&Words { all, eight, word, mask });
            assert_eq!(found, expected, "{}, {mask:b}, {word:x}, {eight:x?}", level.name());
        }
    }
}

struct Powers([f64; LANES]);

impl Job for &Powers {
    type Output = [[f64; LANES]; 2];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [[f64; LANES]; 2] {
        let wide = simd.doubles();
        let power = wide.power(wide.set(self.0));
        let mut powers = [[0.0; LANES]; 2];
        wide.store(power, &mut powers[0]);
        wide.store(wide.inverse_power(power), &mut powers[1]);
        powers
    }
}

#[test]
fn every_set_inverts_powers_of_two() {
    for exponent in (-1022..=1022 - LANES as i32).step_by(3) {
        let powers: [f64; LANES] = std::array::from_fn(|lane| {
            f64::from_bits(((1023 + exponent + lane as i32) as u64) << 52)
        });
        let inverse = powers.map(|power| 1.0 / power);
        let numbers = std::array::from_fn(|lane| powers[lane] * (1.0 + lane as f64 / 8.0));
        for level in Level::available() {
            let found = level.run(&Powers(numbers));
            assert_eq!(found, [powers, inverse], "{}, {exponent}", level.name());
        }
    }
}

/// A job within a job, which uses what only some sets have.
struct Apart<'a>(&'a Words);

impl Job for Apart<'_> {
    type Output = (u32, u32, [u32; LANES]);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        simd.outlined(self.0)
    }
}

#[test]
fn work_apart_is_the_same_work() {
    let all = std::array::from_fn(|i| i as u32 * 3);
    let words = Words { all, eight: [1, 40, 2, 40, 3, 40, 4, 5], word: 40, mask: 0b1000_0001 };
    let set = [40, 40, 2, 40, 3, 40, 4, 40];
    for level in Level::available() {
        assert_eq!(level.run(Apart(&words)), (0b10_1010, (1 << 14) - 1, set), "{}", level.name());
    }
}

/// Numbers to be ordered, as they are and as doubles; rows to be transposed.
struct Order {
    a: [f32; LANES],
    b: [f32; LANES],
    rows: [[f32; LANES]; LANES],
}

/// The smaller and the larger.
type MinMax = [[u64; LANES]; 2];

impl Job for &Order {
    type Output = (MinMax, MinMax, [u32; 2], [[f32; LANES]; LANES]);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let wide = simd.doubles();
        let (a, b) = (simd.load(&self.a), simd.load(&self.b));
        let (mut singles, mut doubles) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        simd.store(simd.min(a, b), &mut singles[0]);
        simd.store(simd.max(a, b), &mut singles[1]);
        let (a, b) = (simd.widen(a), simd.widen(b));
        wide.store(wide.min(a, b), &mut doubles[0]);
        wide.store(wide.max(a, b), &mut doubles[1]);
        let mut rows = [simd.splat(0.0); LANES];
        for row in 0..LANES {
            rows[row] = simd.load(&self.rows[row]);
        }
        let columns = simd.transpose(rows);
        let mut transposed = [[0.0; LANES]; LANES];
        for column in 0..LANES {
            simd.store(columns[column], &mut transposed[column]);
        }
        (
            singles.map(|lanes| lanes.map(|x| f64::from(x).to_bits())),
            doubles.map(|lanes| lanes.map(f64::to_bits)),
            [wide.lt(a, b), wide.le(a, b)],
            transposed,
        )
    }
}

#[test]
fn every_set_orders_and_transposes() {
    let rows = std::array::from_fn(|row| std::array::from_fn(|i| (row * LANES + i) as f32));
    let columns = std::array::from_fn(|column| std::array::from_fn(|row| rows[row][column]));
    for turn in 1..LANES {
        let (a, b) = (HARD, std::array::from_fn(|lane| HARD[(lane + turn) % LANES]));
        // The second number, if one of two doubles is NaN, and if the first of two floats is.
        let min = |lane: usize| if a[lane] < b[lane] { a[lane] } else { b[lane] };
        let max = |lane: usize| if a[lane] > b[lane] { a[lane] } else { b[lane] };
        let bits = |of: &dyn Fn(usize) -> f32| -> [u64; LANES] {
            std::array::from_fn(|lane| f64::from(of(lane)).to_bits())
        };
        let min_max = [bits(&min), bits(&max)];
        let mask = |is: &dyn Fn(usize) -> bool| {
            (0..LANES).fold(0, |bits, lane| bits | u32::from(is(lane)) << lane)
        };
        let masks = [mask(&|lane| a[lane] < b[lane]), mask(&|lane| a[lane] <= b[lane])];
        for level in Level::available() {
            let (singles, doubles, found_masks, transposed) = level.run(&Order { a, b, rows });
            assert_eq!(doubles, min_max, "{level}: {a:?}, {b:?}");
            assert_eq!(found_masks, masks, "{level}: {a:?}, {b:?}");
            assert_eq!(transposed, columns, "{level}");
            for lane in (0..LANES).filter(|&lane| !b[lane].is_nan()) {
                // Of two zeros it may be either.
                let is_zero = a[lane] == 0.0 && b[lane] == 0.0;
                for (found, expected) in singles.iter().zip(&min_max) {
                    let is_right = is_zero && f64::from_bits(found[lane]) == 0.0;
                    assert!(is_right || found[lane] == expected[lane], "{level}: {a:?}, {b:?}");
                }
            }
        }
    }
}
