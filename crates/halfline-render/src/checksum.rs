//! A number that tells bytes from other bytes: damage, not deceit.

/// Mixes `bytes` eight at a time as FNV-1a (Fowler, Noll, Vo 1991) mixes single ones. Every step maps
/// different states to different ones, so that a change within one word can never go unseen.
pub(crate) fn checksum(bytes: &[u8]) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let step = |state: u64, word: u64| (state ^ word).wrapping_mul(PRIME).rotate_left(29);
    let (words, rest) = bytes.as_chunks::<8>();
    let state = words.iter().fold(OFFSET, |state, &word| step(state, u64::from_le_bytes(word)));
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    // The length tells zeros at the end from none.
    step(step(state, u64::from_le_bytes(last)), bytes.len() as u64)
}
