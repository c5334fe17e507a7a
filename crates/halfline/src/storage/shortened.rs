//! What happens when somebody cuts a mapped file short.
//!
//! Touching a page beyond the file's new end raises SIGBUS, which by default ends the process without
//! a word. Here a handler answers it: it puts pages of zeros in the place of those that are gone and
//! notes that it did, the reader goes on, and whoever asked for the work is told that the file was cut
//! short. What reads a map must therefore come to an end on zeros too.
//!
//! A SIGBUS anywhere else goes to the handler that was there before.

use std::mem::MaybeUninit;
use std::ptr::null_mut;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicUsize, Ordering};

/// The address range of a map. Entries are made once and used again, never freed: the handler may
/// look at any of them at any time.
#[derive(Debug)]
struct Entry {
    /// Zero in an entry that is free.
    start: AtomicUsize,
    end: AtomicUsize,
    was_shortened: AtomicBool,
    /// Set once, before the entry can be found.
    next: AtomicPtr<Entry>,
}

/// The entry that was made last.
static ENTRIES: AtomicPtr<Entry> = AtomicPtr::new(null_mut());

/// In an entry that is taken and has no range yet.
const TAKEN: usize = 1;

/// A map that the handler watches over, until this is dropped.
#[derive(Debug)]
pub struct Region(&'static Entry);

impl Region {
    /// Has the handler answer for a map of a file.
    pub fn watch_over(map: &[u8]) -> Region {
        install();
        let range = map.as_ptr_range();
        let entry = free_entry().unwrap_or_else(new_entry);
        entry.was_shortened.store(false, Ordering::SeqCst);
        entry.end.store(range.end.addr(), Ordering::SeqCst);
        entry.start.store(range.start.addr(), Ordering::SeqCst);
        Region(entry)
    }

    /// True once the handler has answered for this map.
    pub fn was_shortened(&self) -> bool {
        self.0.was_shortened.load(Ordering::SeqCst)
    }
}

impl Drop for Region {
    fn drop(&mut self) {
        self.0.start.store(0, Ordering::SeqCst);
    }
}

/// All entries. Only atomics are read: the handler may come at any time.
#[allow(unsafe_code)]
fn entries() -> impl Iterator<Item = &'static Entry> {
    let at = |entry: *mut Entry| {
        // SAFETY: the pointer is null or comes from `new_entry`, which leaks what it points to.
        unsafe { entry.as_ref() }
    };
    std::iter::successors(at(ENTRIES.load(Ordering::SeqCst)), move |entry| {
        at(entry.next.load(Ordering::SeqCst))
    })
}

fn free_entry() -> Option<&'static Entry> {
    entries().find(|entry| {
        entry.start.compare_exchange(0, TAKEN, Ordering::SeqCst, Ordering::SeqCst).is_ok()
    })
}

fn new_entry() -> &'static Entry {
    let entry: &'static Entry = Box::leak(Box::new(Entry {
        start: TAKEN.into(),
        end: 0.into(),
        was_shortened: false.into(),
        next: AtomicPtr::new(null_mut()),
    }));
    let mut first = ENTRIES.load(Ordering::SeqCst);
    loop {
        entry.next.store(first, Ordering::SeqCst);
        let pointer = std::ptr::from_ref(entry).cast_mut();
        match ENTRIES.compare_exchange(first, pointer, Ordering::SeqCst, Ordering::SeqCst) {
            Ok(_) => return entry,
            Err(now) => first = now,
        }
    }
}

/// What was to answer SIGBUS before; written once, before the handler is installed.
static mut PREVIOUS: MaybeUninit<libc::sigaction> = MaybeUninit::zeroed();
static PAGE_SIZE: AtomicUsize = AtomicUsize::new(0);
static INSTALLED: Once = Once::new();

#[allow(unsafe_code)]
fn install() {
    INSTALLED.call_once(|| {
        // SAFETY: sysconf and sigaction are called with valid arguments; `PREVIOUS` is written here
        // alone, once, before the handler that reads it can run. The handler touches atomics and
        // calls mmap and sigaction only, which are plain system calls.
        unsafe {
            PAGE_SIZE.store(libc::sysconf(libc::_SC_PAGESIZE) as usize, Ordering::SeqCst);
            libc::sigaction(libc::SIGBUS, std::ptr::null(), (&raw mut PREVIOUS).cast());
            let mut action: libc::sigaction = MaybeUninit::zeroed().assume_init();
            action.sa_sigaction =
                answer as extern "C" fn(i32, *mut libc::siginfo_t, *mut libc::c_void) as usize;
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigemptyset(&raw mut action.sa_mask);
            libc::sigaction(libc::SIGBUS, &raw const action, null_mut());
        }
    });
}

/// The handler.
#[allow(unsafe_code)]
extern "C" fn answer(signal: i32, info: *mut libc::siginfo_t, context: *mut libc::c_void) {
    // SAFETY: the system hands a valid `info` to handlers that ask for it.
    let address = unsafe { (*info).si_addr() }.addr();
    let watched = entries().find(|entry| {
        let (start, end) = (entry.start.load(Ordering::SeqCst), entry.end.load(Ordering::SeqCst));
        start > TAKEN && (start..end).contains(&address)
    });
    if let Some(entry) = watched {
        // All that comes after is beyond the file's end too.
        let page = address & !(PAGE_SIZE.load(Ordering::SeqCst) - 1);
        let length = entry.end.load(Ordering::SeqCst) - page;
        // SAFETY: the range is the end of a map of ours, which only lives on to be read; fresh pages
        // of zeros in its place are as good to read, and are unmapped with the rest.
        let zeros = unsafe {
            let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_FIXED;
            libc::mmap(page as *mut libc::c_void, length, libc::PROT_READ, flags, -1, 0)
        };
        if zeros != libc::MAP_FAILED {
            entry.was_shortened.store(true, Ordering::SeqCst);
            return;
        }
    }

    // SAFETY: `PREVIOUS` was filled before this handler was installed. What it names is a handler of
    // the form that its flags say; without one the default is put back, and the same access, made
    // again, ends the process.
    unsafe {
        let previous: libc::sigaction = (&raw const PREVIOUS).read().assume_init();
        match previous.sa_sigaction {
            libc::SIG_DFL | libc::SIG_IGN => {
                libc::sigaction(signal, &raw const previous, null_mut());
            }
            handler if previous.sa_flags & libc::SA_SIGINFO != 0 => {
                let handler: extern "C" fn(i32, *mut libc::siginfo_t, *mut libc::c_void) =
                    std::mem::transmute(handler);
                handler(signal, info, context);
            }
            handler => {
                let handler: extern "C" fn(i32) = std::mem::transmute(handler);
                handler(signal);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use crate::storage::MappedFile;

    #[test]
    fn a_file_cut_short_reads_as_zeros_and_tells() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let length = 100_000;
        std::fs::write(&path, vec![7; length]).unwrap();
        let file = File::open(&path).unwrap();
        let [map, other] = [0, 1].map(|_| MappedFile::new(&file).expect("maps"));
        assert_eq!((map[length - 1], map.was_shortened()), (7, false));
        File::options().write(true).open(&path).unwrap().set_len(10).unwrap();
        assert_eq!(map[50_000], 0);
        assert_eq!((map[length - 1], map[5], map.was_shortened()), (0, 7, true));
        assert!(!other.was_shortened(), "nothing was missed there yet");
        assert_eq!((other[length - 1], other.was_shortened()), (0, true));

        // The entry is used again, and knows nothing of what was before.
        drop((map, other));
        let map = MappedFile::new(&file).expect("maps");
        assert!(!map.was_shortened());
        assert_eq!(&map[..3], [7; 3]);
    }
}
