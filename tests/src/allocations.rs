//! An allocator that counts what each thread asks of it.
//!
//! A test program makes it its own: `#[global_allocator] static ALLOCATOR: Counting = Counting;`.
//! Invariant: everything is handed on to the system's allocator as it came.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts what a thread asks of the allocator.
#[derive(Clone, Copy, Debug)]
pub struct Counting;

thread_local! {
    static REQUESTS: Cell<u64> = const { Cell::new(0) };
    static HELD_BYTES: Cell<i64> = const { Cell::new(0) };
    static IS_MARKED: Cell<bool> = const { Cell::new(false) };
}

/// What all marked threads together asked for: how often, and how many bytes.
static MARKED_REQUESTS: AtomicU64 = AtomicU64::new(0);
static MARKED_BYTES: AtomicU64 = AtomicU64::new(0);

fn note(more_bytes: usize, less_bytes: usize) {
    REQUESTS.set(REQUESTS.get() + 1);
    HELD_BYTES.set(HELD_BYTES.get() + more_bytes as i64 - less_bytes as i64);
    if more_bytes > 0 && IS_MARKED.get() {
        MARKED_REQUESTS.fetch_add(1, Ordering::Relaxed);
        MARKED_BYTES.fetch_add(more_bytes as u64, Ordering::Relaxed);
    }
}

// SAFETY: hands everything on to the system's allocator as it is; the counter is a plain cell that allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size(), 0);
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        note(new_size, layout.size());
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.realloc(memory, layout, new_size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        note(0, layout.size());
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// How often this thread asked for memory or gave it back so far.
#[must_use]
pub fn requests_so_far() -> u64 {
    REQUESTS.get()
}

/// Bytes that this thread asked for and has not given back; what another thread gives back is not known.
#[must_use]
pub fn held_bytes() -> i64 {
    HELD_BYTES.get()
}

/// How often `work` did.
pub fn requests(work: impl FnOnce()) -> u64 {
    let before = requests_so_far();
    work();
    requests_so_far() - before
}

/// Counts from now on what this thread asks for among what all marked ones do.
pub fn mark_this_thread() {
    IS_MARKED.set(true);
}

/// How often all marked threads asked for memory so far, and for how many bytes; what they gave back is not counted.
#[must_use]
pub fn asked_by_marked() -> (u64, u64) {
    (MARKED_REQUESTS.load(Ordering::Relaxed), MARKED_BYTES.load(Ordering::Relaxed))
}
