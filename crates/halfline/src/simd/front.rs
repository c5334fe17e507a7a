//! Which lanes go to the front, for sets that have no instruction that moves them there.

use super::LANES;

/// For each set of lanes their numbers, those of the set first.
pub static FRONT: [[u8; LANES]; 256] = front();

const fn front() -> [[u8; LANES]; 256] {
    let mut table = [[0; LANES]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < LANES {
            if set >> lane & 1 == 1 {
                table[set][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    table
}
