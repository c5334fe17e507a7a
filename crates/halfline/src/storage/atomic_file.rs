//! Files that appear whole or not at all.

use std::fs::{File, Metadata, OpenOptions, Permissions};
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// Bytes gathered before the operating system is asked to write them.
const BUFFER_BYTES: usize = 1 << 20;

/// Symbolic links followed from the path to the file, as many as Linux follows.
const MOST_LINKS: usize = 40;

/// Where the open files of a process have names, whatever names they have elsewhere. Not all of
/// `/dev`: ordinary files live in `/dev/shm`.
const OPEN_FILES: [&str; 4] = ["/dev/fd", "/dev/stdout", "/dev/stderr", "/proc"];

/// A file that is written beside its target and takes the target's place at [`commit`].
///
/// Dropped before that, it leaves no trace and the target as it was. A target that is a symbolic
/// link stays one: the file that it points to is replaced. What is not a regular file (a pipe, a
/// device, `/dev/stdout`) is written to directly, and cannot be taken back.
///
/// [`commit`]: AtomicFile::commit
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    output: Output,
}

#[derive(Debug)]
enum Output {
    /// A file beside `target`, to be renamed to it.
    Beside {
        file: BufWriter<NamedTempFile>,
        target: PathBuf,
        /// Dropped after the file, and so after its removal.
        _listed: Listed,
    },
    Direct(BufWriter<File>),
}

/// The files of this process that are still beside their targets.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what every [`AtomicFile`] of the process has written so far, and lets none of them be
/// committed any more: for those who end the process while others still write.
pub fn abandon_all() {
    let unfinished = unfinished();
    for path in &*unfinished {
        let _ = std::fs::remove_file(path);
    }
    // Never unlocked again: a file begun or committed from now on would escape.
    std::mem::forget(unfinished);
}

/// An entry of [`UNFINISHED`], for as long as this lives.
#[derive(Debug)]
struct Listed(PathBuf);

impl Listed {
    fn new(path: &Path, list: &mut Vec<PathBuf>) -> Listed {
        list.push(path.to_owned());
        Listed(path.to_owned())
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

/// What a path leads to.
enum Target {
    /// A regular file, or a name that is free.
    Regular(PathBuf, Option<Metadata>),
    /// Something to write to as it is.
    Stream(PathBuf),
}

impl AtomicFile {
    /// Begins to write the file that will be at `path`.
    ///
    /// # Errors
    /// [`Error::Io`] if the folder does not exist or cannot be written to, if `path` is a folder,
    /// or if it is a file that one may not write to.
    pub fn create(path: &Path) -> Result<AtomicFile> {
        let failed = |e| Error::io(path, e);
        let output = match resolve(path).map_err(failed)? {
            Target::Stream(stream) => {
                let file = OpenOptions::new().append(true).open(stream).map_err(failed)?;
                Output::Direct(BufWriter::with_capacity(BUFFER_BYTES, file))
            }
            Target::Regular(target, existing) => {
                let (file, listed) = create_beside(&target, existing).map_err(failed)?;
                let file = BufWriter::with_capacity(BUFFER_BYTES, file);
                Output::Beside { file, target, _listed: listed }
            }
        };
        Ok(AtomicFile { path: path.to_owned(), output })
    }

    /// The path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes what was written durable and visible at the path.
    pub fn commit(self) -> Result<()> {
        self.commit_with(None)
    }

    /// Commits as [`AtomicFile::commit`] does, as a file that was last modified at `time`, if the path's
    /// file system can tell.
    pub fn commit_as_of(self, time: SystemTime) -> Result<()> {
        self.commit_with(Some(time))
    }

    fn commit_with(self, time: Option<SystemTime>) -> Result<()> {
        let AtomicFile { path, output } = self;
        let committed = match output {
            Output::Beside { file, target, _listed } => replace(file, &target, time),
            Output::Direct(mut file) => file.flush(),
        };
        committed.map_err(|e| Error::io(&path, e))
    }
}

/// Follows symbolic links to the place where the file has to appear.
fn resolve(path: &Path) -> std::io::Result<Target> {
    let mut place = path.to_owned();
    for _ in 0..MOST_LINKS {
        if OPEN_FILES.iter().any(|names| place.starts_with(names)) {
            return Ok(Target::Stream(place));
        }
        let metadata = match std::fs::symlink_metadata(&place) {
            Ok(metadata) => metadata,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                return Ok(Target::Regular(place, None));
            }
            Err(e) => return Err(e),
        };
        if metadata.is_dir() {
            return Err(std::io::ErrorKind::IsADirectory.into());
        }
        if metadata.is_file() {
            return Ok(Target::Regular(place, Some(metadata)));
        }
        if !metadata.is_symlink() {
            return Ok(Target::Stream(place));
        }
        place = folder_of(&place).join(std::fs::read_link(&place)?);
    }
    Err(std::io::Error::other("too many symbolic links"))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// An empty file in the folder of `target`, with the permissions that `target` has or would get.
fn create_beside(
    target: &Path,
    existing: Option<Metadata>,
) -> std::io::Result<(NamedTempFile, Listed)> {
    if target.file_name().is_none() {
        return Err(std::io::ErrorKind::IsADirectory.into());
    }
    if existing.is_some() {
        // Renaming would replace even a write-protected file; its owner meant it to stay.
        OpenOptions::new().write(true).open(target)?;
    }
    std::fs::metadata(folder_of(target))?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".halfline-").suffix(".part");
    if let Some(permissions) = ordinary_permissions() {
        builder.permissions(permissions);
    }
    // One step for [`abandon_all`]: there is no file that is not listed.
    let mut list = unfinished();
    let file = builder.tempfile_in(folder_of(target)).map_err(without_path)?;
    let listed = Listed::new(file.path(), &mut list);
    drop(list);
    if let Some(existing) = existing {
        file.as_file().set_permissions(existing.permissions())?;
    }
    Ok((file, listed))
}

/// Read and write for all, from which the operating system takes the umask away.
#[cfg(unix)]
fn ordinary_permissions() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn ordinary_permissions() -> Option<Permissions> {
    None
}

/// The reason alone; tempfile adds the name of the temporary file, which the user never asked for.
fn without_path(error: std::io::Error) -> std::io::Error {
    error.kind().into()
}

fn replace(
    file: BufWriter<NamedTempFile>,
    target: &Path,
    time: Option<SystemTime>,
) -> std::io::Result<()> {
    let file = file.into_inner().map_err(|e| e.into_error())?;
    if let Some(time) = time {
        let _ = file.as_file().set_modified(time);
    }
    file.as_file().sync_all()?;
    let list = unfinished();
    let persisted = file.persist(target);
    // Before the file is dropped, should it still be there.
    drop(list);
    persisted.map_err(|e| e.error)?;
    // The rename itself is durable once the folder is. Not every file system can do this, and
    // the file is whole either way.
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder_of(target)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match &mut self.output {
            Output::Beside { file, .. } => file.write(bytes),
            Output::Direct(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match &mut self.output {
            Output::Beside { file, .. } => file.flush(),
            Output::Direct(file) => file.flush(),
        }
    }
}

impl Seek for AtomicFile {
    /// Fails for what is not a regular file: it takes bytes in order only.
    fn seek(&mut self, position: SeekFrom) -> std::io::Result<u64> {
        match &mut self.output {
            Output::Beside { file, .. } => file.seek(position),
            Output::Direct(_) => Err(std::io::ErrorKind::NotSeekable.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path, content: &[u8]) -> Result<()> {
        let mut file = AtomicFile::create(path)?;
        file.write_all(content).unwrap();
        file.commit()
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn the_target_appears_at_commit_and_nothing_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"abc").unwrap();
        assert!(!path.exists());
        file.seek(SeekFrom::Start(1)).unwrap();
        file.write_all(b"B").unwrap();
        file.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"aBc");
        assert_eq!(names(folder.path()), ["out"]);
    }

    #[test]
    fn dropped_before_commit_it_leaves_the_target_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        write(&path, b"old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(&vec![0; 3 * BUFFER_BYTES]).unwrap();
        drop(file);
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["out"]);
    }

    #[test]
    fn files_are_listed_for_abandonment_exactly_while_they_are_unfinished() {
        let folder = tempfile::tempdir().unwrap();
        // Other tests run at the same time: only this folder's files count.
        let listed = || {
            unfinished().iter().filter(|path| path.starts_with(folder.path())).cloned().collect()
        };
        let first = AtomicFile::create(&folder.path().join("a")).unwrap();
        let second = AtomicFile::create(&folder.path().join("b")).unwrap();
        let both: Vec<PathBuf> = listed();
        assert!(both.len() == 2 && both.iter().all(|path| path.is_file()), "{both:?}");
        drop(first);
        let one: Vec<PathBuf> = listed();
        assert_eq!(one, both[1..]);
        second.commit().unwrap();
        assert_eq!(listed(), Vec::<PathBuf>::new());
    }

    #[test]
    fn a_folder_or_a_missing_folder_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = AtomicFile::create(folder.path()).unwrap_err().to_string();
        assert!(error.contains("directory"), "{error}");
        let path = folder.path().join("none").join("out");
        let error = AtomicFile::create(&path).unwrap_err().to_string();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
        assert!(!error.contains(".part"), "{error}");
        assert!(AtomicFile::create(Path::new("")).is_err());
    }

    #[cfg(unix)]
    mod unix {
        use std::os::unix::fs::{PermissionsExt, symlink};

        use super::*;

        fn mode(path: &Path) -> u32 {
            std::fs::metadata(path).unwrap().permissions().mode() & 0o7777
        }

        #[test]
        fn permissions_are_those_of_an_ordinary_file_or_of_the_replaced_one() {
            let folder = tempfile::tempdir().unwrap();
            let (ordinary, path) = (folder.path().join("ordinary"), folder.path().join("out"));
            std::fs::write(&ordinary, b"").unwrap();
            write(&path, b"1").unwrap();
            assert_eq!(mode(&path), mode(&ordinary));
            std::fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
            write(&path, b"2").unwrap();
            assert_eq!(mode(&path), 0o640);
            assert_eq!(std::fs::read(&path).unwrap(), b"2");
        }

        #[test]
        fn a_link_stays_a_link_whether_its_target_exists_or_not() {
            let folder = tempfile::tempdir().unwrap();
            let inner = folder.path().join("inner");
            std::fs::create_dir(&inner).unwrap();
            let (first, second) = (folder.path().join("first"), inner.join("second"));
            symlink("inner/second", &first).unwrap();
            symlink("third", &second).unwrap();
            for content in [b"a", b"b"] {
                write(&first, content).unwrap();
                assert!(first.is_symlink() && second.is_symlink());
                assert_eq!(std::fs::read(inner.join("third")).unwrap(), content);
                assert_eq!(names(&inner), ["second", "third"]);
            }
        }

        #[test]
        fn links_in_a_circle_are_an_error() {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("circle");
            symlink("circle", &path).unwrap();
            let error = AtomicFile::create(&path).unwrap_err().to_string();
            assert!(error.contains("too many symbolic links"), "{error}");
        }

        #[test]
        fn a_device_is_written_to_directly() {
            let folder = tempfile::tempdir().unwrap();
            let link = folder.path().join("null");
            symlink("/dev/null", &link).unwrap();
            let mut file = AtomicFile::create(&link).unwrap();
            file.write_all(b"abc").unwrap();
            assert!(file.seek(SeekFrom::Start(0)).is_err());
            file.commit().unwrap();
            assert!(link.is_symlink());
            assert_eq!(names(folder.path()), ["null"]);
        }

        #[cfg(target_os = "linux")]
        #[test]
        fn shared_memory_is_a_folder_like_others() {
            let folder = tempfile::tempdir_in("/dev/shm").unwrap();
            let path = folder.path().join("out");
            for content in [b"first", b"again"] {
                write(&path, content).unwrap();
                assert_eq!(std::fs::read(&path).unwrap(), content);
            }
            assert_eq!(names(folder.path()), ["out"]);
        }

        #[test]
        fn an_open_file_of_the_process_is_appended_to() {
            use std::os::fd::AsRawFd;
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("log");
            std::fs::write(&path, b"before ").unwrap();
            let open = OpenOptions::new().append(true).open(&path).unwrap();
            let alias = PathBuf::from(format!("/dev/fd/{}", open.as_raw_fd()));
            if alias.exists() {
                write(&alias, b"after").unwrap();
                assert_eq!(std::fs::read(&path).unwrap(), b"before after");
            }
        }
    }
}
