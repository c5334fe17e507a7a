//! Fresh arrays in as few pages as possible.

/// An array of `count` zeros, as far as possible in huge pages that nobody has touched yet.
///
/// Reading a large file is bound by the first touches of the memory that it is read to: with pages
/// of 4 KiB they cost twice as much as everything else together. Whoever fills the array should do
/// so in parallel, since a page is cleared by the thread that touches it first.
pub fn zeroed<T: Copy>(zero: T, count: usize) -> Vec<T> {
    let mut items = vec![zero; count];
    advise_huge_pages(&mut items);
    items
}

/// Asks that the memory of `items` be backed by huge pages, which matters most before it is touched:
/// random reads of a large array then miss the translation cache far less often.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
pub fn advise_huge_pages<T>(items: &mut [T]) {
    const HUGE_PAGE: usize = 2 << 20;
    let start = items.as_mut_ptr().cast::<u8>();
    let skipped = start.align_offset(HUGE_PAGE);
    let Some(rest) = size_of_val(items).checked_sub(skipped) else {
        return;
    };
    let length = rest - rest % HUGE_PAGE;
    if length > 0 {
        // SAFETY: the range lies within `items`, which is borrowed mutably. The advice changes by
        // which pages the range is backed, never what it holds, and its failure changes nothing.
        unsafe { libc::madvise(start.add(skipped).cast(), length, libc::MADV_HUGEPAGE) };
    }
}

/// There is no such advice here.
#[cfg(not(target_os = "linux"))]
pub fn advise_huge_pages<T>(_: &mut [T]) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresh_arrays_of_all_sizes_are_zero() {
        for count in [0, 1, 1000, 600_000, 3_000_001] {
            let mut items = zeroed([0_u32; 3], count);
            assert_eq!(items.len(), count);
            assert!(items.iter().all(|item| *item == [0; 3]));
            items.fill([7; 3]);
            items.push([8; 3]);
            assert!(items[..count].iter().all(|item| *item == [7; 3]));
        }
    }
}
