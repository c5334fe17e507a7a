//! Numbers as colours.

/// The colour map "inferno" of matplotlib (Smith and van der Walt 2015, CC0): brightness rises
/// evenly from black to pale yellow, for those who see no colours too. Every eighth of its 256
/// entries and the last, sRGB-encoded.
#[rustfmt::skip]
const INFERNO: [[u8; 3]; 33] = [
    [0, 0, 4], [4, 3, 18], [11, 7, 36], [21, 11, 55], [33, 12, 74], [47, 10, 91],
    [61, 9, 101], [74, 12, 107], [87, 16, 110], [100, 21, 110], [113, 25, 110], [125, 30, 109],
    [138, 34, 106], [151, 39, 102], [163, 44, 97], [176, 49, 91], [188, 55, 84], [199, 62, 76],
    [210, 70, 68], [219, 80, 59], [228, 90, 49], [235, 102, 40], [241, 115, 29], [246, 128, 19],
    [249, 142, 9], [251, 157, 7], [252, 172, 17], [251, 188, 33], [249, 203, 53], [245, 219, 76],
    [242, 234, 105], [243, 246, 138], [252, 255, 164],
];

/// The sRGB-encoded colour of `share`, from 0 to 1; values outside are clamped, NaN is 0.
pub(crate) fn inferno(share: f32) -> [f32; 3] {
    let intervals = (INFERNO.len() - 1) as f32;
    let position = if share > 0.0 { share.min(1.0) * intervals } else { 0.0 };
    let i = (position as usize).min(INFERNO.len() - 2);
    let weight = position - i as f32;
    std::array::from_fn(|c| {
        let (low, high) = (f32::from(INFERNO[i][c]), f32::from(INFERNO[i + 1][c]));
        (low + (high - low) * weight) / 255.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_rises_all_the_way() {
        let brightness = |i: usize| {
            let [r, g, b] = inferno(i as f32 / 256.0).map(halfline::mesh::linear_from_srgb);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((1..=256).all(|i| brightness(i) > brightness(i - 1)));
    }

    #[test]
    fn ends_and_outsiders_have_the_colours_of_the_ends() {
        let first = INFERNO[0].map(|v| f32::from(v) / 255.0);
        let last = INFERNO[32].map(|v| f32::from(v) / 255.0);
        assert_eq!([f32::NAN, -1.0, 0.0].map(inferno), [first; 3]);
        assert_eq!([1.0, 2.0, f32::INFINITY].map(inferno), [last; 3]);
    }
}
