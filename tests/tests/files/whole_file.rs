//! Files are written whole or not at all: what stood there stays until the last byte is on the disk.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use pottery_client::whole_file::{WriteError, write_whole};
use pottery_tests::programs::folder;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn write(path: &Path, text: &str) -> Result<(), WriteError> {
    write_whole(path, |out| out.write_all(text.as_bytes()))
}

fn sentence(result: Result<(), WriteError>) -> String {
    let text = result.unwrap_err().to_string();
    assert!((20..300).contains(&text.len()) && !text.contains(['\n', '{', '}']), "{text}");
    text
}

#[test]
fn file_takes_the_place_of_the_one_before() {
    let folder = folder("whole-replaced");
    let path = folder.join("pot.stl");
    write(&path, "one").unwrap();
    write(&path, "two").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "two");
    assert_eq!(names(&folder), ["pot.stl"]);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn writer_that_gives_up_leaves_the_old_file_and_no_other() {
    let folder = folder("whole-given-up");
    let path = folder.join("pot.stl");
    write(&path, "old").unwrap();
    for path in [&path, &folder.join("other.stl")] {
        let text = sentence(write_whole(path, |out| {
            out.write_all(&[0; 100_000])?;
            Err(io::ErrorKind::StorageFull.into())
        }));
        assert!(text.contains(path.to_str().unwrap()), "{text}");
    }
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(&folder), ["pot.stl"]);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn reader_never_sees_half_a_file() {
    let folder = folder("whole-half");
    let path = folder.join("pot.stl");
    write(&path, "old").unwrap();
    write_whole(&path, |out| {
        out.write_all(b"half")?;
        out.flush()?;
        assert_eq!(fs::read_to_string(&path)?, "old");
        out.write_all(b", whole")
    })
    .unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "half, whole");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn folder_in_place_of_a_file_is_said() {
    let folder = folder("whole-folder");
    let text = sentence(write(&folder, "x"));
    assert!(text.contains("is a folder"), "{text}");
    assert!(names(&folder).is_empty());
    for missing in [folder.join("none/pot.stl"), PathBuf::new()] {
        sentence(write(&missing, "x"));
    }
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(unix)]
#[test]
fn protected_file_stays_and_permissions_do() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("whole-protected");
    let path = folder.join("pot.stl");
    write(&path, "old").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    write(&path, "new").unwrap();
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o440)).unwrap();
    sentence(write(&path, "never"));
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(names(&folder), ["pot.stl"]);
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(unix)]
#[test]
fn link_goes_on_pointing_at_what_was_written() {
    let folder = folder("whole-link");
    let (file, link) = (folder.join("pot.stl"), folder.join("newest.stl"));
    write(&file, "old").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    write(&link, "new").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read_to_string(&file).unwrap(), "new");
    fs::remove_dir_all(folder).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn full_device_is_said_and_stays_a_device() {
    use std::os::unix::fs::FileTypeExt;
    let text = sentence(write(Path::new("/dev/full"), "no room for this"));
    assert!(text.contains("/dev/full") && text.contains("No space left"), "{text}");
    assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
    write(Path::new("/dev/null"), "gone").unwrap();
}
