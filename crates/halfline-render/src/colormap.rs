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

/// The diverging colour map of K. Moreland, "Diverging Color Maps for Scientific Visualization" (ISVC
/// 2009): from blue over grey to red, evenly in a space made for it, for shaded surfaces, and told apart
/// by those who confuse red and green. 33 entries, sRGB-encoded.
#[rustfmt::skip]
const COOL_WARM: [[u8; 3]; 33] = [
    [59, 76, 192], [68, 90, 204], [78, 104, 215], [88, 117, 225], [98, 130, 234], [108, 142, 241],
    [119, 154, 247], [130, 165, 251], [141, 176, 254], [152, 185, 255], [163, 194, 254],
    [174, 201, 253], [184, 208, 249], [194, 213, 244], [204, 217, 238], [213, 219, 230],
    [221, 221, 221], [229, 216, 209], [236, 211, 198], [241, 204, 185], [245, 196, 173],
    [247, 187, 160], [247, 177, 148], [247, 166, 135], [244, 154, 123], [241, 141, 111],
    [236, 127, 99], [229, 112, 87], [222, 97, 76], [213, 80, 66], [203, 62, 56], [192, 40, 47],
    [180, 4, 38],
];

/// The sRGB-encoded colour of `share`, from 0 to 1; values outside are clamped, NaN is 0.
pub(crate) fn inferno(share: f32) -> [f32; 3] {
    between(&INFERNO, share)
}

/// The sRGB-encoded colour of `share`, from 0, blue, to 1, red; values outside are clamped, NaN is 0.
pub(crate) fn cool_warm(share: f32) -> [f32; 3] {
    between(&COOL_WARM, share)
}

/// The colour between entries, evenly spread from 0 to 1.
fn between(entries: &[[u8; 3]; 33], share: f32) -> [f32; 3] {
    let intervals = (entries.len() - 1) as f32;
    let position = if share > 0.0 { share.min(1.0) * intervals } else { 0.0 };
    let i = (position as usize).min(entries.len() - 2);
    let weight = position - i as f32;
    std::array::from_fn(|c| {
        let (low, high) = (f32::from(entries[i][c]), f32::from(entries[i + 1][c]));
        (low + (high - low) * weight) / 255.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brightness(color: [f32; 3]) -> f32 {
        let [r, g, b] = color.map(halfline::mesh::linear_from_srgb);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    #[test]
    fn brightness_rises_all_the_way() {
        let at = |i: usize| brightness(inferno(i as f32 / 256.0));
        assert!((1..=256).all(|i| at(i) > at(i - 1)));
    }

    #[test]
    fn both_ends_are_darker_than_the_middle() {
        let at = |i: usize| brightness(cool_warm(i as f32 / 256.0));
        assert!((1..=128).all(|i| at(i) > at(i - 1)));
        assert!((129..=256).all(|i| at(i) < at(i - 1)));
    }

    #[test]
    fn ends_and_outsiders_have_the_colours_of_the_ends() {
        let first = INFERNO[0].map(|v| f32::from(v) / 255.0);
        let last = INFERNO[32].map(|v| f32::from(v) / 255.0);
        assert_eq!([f32::NAN, -1.0, 0.0].map(inferno), [first; 3]);
        assert_eq!([1.0, 2.0, f32::INFINITY].map(inferno), [last; 3]);
    }
}
