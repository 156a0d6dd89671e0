//! What all targets share: an allocator that refuses more than an input may take, so that it counts as a crash.

use std::alloc::{GlobalAlloc, Layout, System};

use crossgrain_fuzz::MOST_MEMORY;

struct Bounded;

// SAFETY: the system's allocator does everything; what it is not asked for is refused, as any allocator may.
unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() as u64 > MOST_MEMORY {
            return std::ptr::null_mut();
        }
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if size as u64 > MOST_MEMORY {
            return std::ptr::null_mut();
        }
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Bounded = Bounded;
