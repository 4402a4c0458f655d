//! An allocator that counts what each thread asks of it.
//!
//! A test program makes it its own: `#[global_allocator] static ALLOCATOR: Counting = Counting;`.
//! Invariant: everything is handed on to the system's allocator as it came.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Counts what a thread asks of the allocator.
#[derive(Clone, Copy, Debug)]
pub struct Counting;

thread_local! {
    static REQUESTS: Cell<u64> = const { Cell::new(0) };
    static HELD_BYTES: Cell<i64> = const { Cell::new(0) };
}

fn note(more_bytes: usize, less_bytes: usize) {
    REQUESTS.set(REQUESTS.get() + 1);
    HELD_BYTES.set(HELD_BYTES.get() + more_bytes as i64 - less_bytes as i64);
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
