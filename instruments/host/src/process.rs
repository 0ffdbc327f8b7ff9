//! The threads and the allocated memory of this process, as the operating system lists them.

pub(crate) use system::{allocated_bytes, disable_error_dialogs, thread_ids};

#[cfg(target_os = "linux")]
mod system {
    /// Returns the identifiers of this process's threads, if the system lists them.
    pub(crate) fn thread_ids() -> Option<Vec<u32>> {
        let entries = std::fs::read_dir("/proc/self/task").ok()?;
        let names = entries.flatten().map(|entry| entry.file_name());
        Some(
            names
                .filter_map(|name| name.to_string_lossy().parse().ok())
                .collect(),
        )
    }

    /// Returns the bytes allocated in this process, where the C library is glibc 2.33 or newer.
    pub(crate) fn allocated_bytes() -> Option<usize> {
        #[cfg(target_env = "gnu")]
        {
            /// `struct mallinfo2`, see mallinfo(3).
            #[repr(C)]
            struct MallInfo2 {
                fields: [usize; 10],
            }
            type GetMallInfo2 = unsafe extern "C" fn() -> MallInfo2;
            /// Index of `hblkhd`, the bytes in mapped blocks.
            const MAPPED: usize = 4;
            /// Index of `uordblks`, the bytes allocated in arenas.
            const ARENA: usize = 7;
            let process = libloading::os::unix::Library::this();
            // SAFETY: the type is that of the manual page.
            let mallinfo2 = unsafe { process.get::<GetMallInfo2>(b"mallinfo2\0") }.ok()?;
            // SAFETY: takes no arguments.
            let info = unsafe { mallinfo2() };
            Some(info.fields[MAPPED] + info.fields[ARENA])
        }
        #[cfg(not(target_env = "gnu"))]
        None
    }

    /// Does nothing: a crash ends the process at once.
    pub(crate) fn disable_error_dialogs() {}
}

#[cfg(windows)]
mod system {
    use std::os::windows::io::{AsRawHandle, FromRawHandle, OwnedHandle};

    use windows_sys::Win32::Foundation::{HANDLE, INVALID_HANDLE_VALUE};
    use windows_sys::Win32::System::Diagnostics::Debug::{
        SEM_FAILCRITICALERRORS, SEM_NOGPFAULTERRORBOX, SetErrorMode,
    };
    use windows_sys::Win32::System::Diagnostics::ToolHelp::{
        CreateToolhelp32Snapshot, TH32CS_SNAPTHREAD, THREADENTRY32, Thread32First, Thread32Next,
    };
    use windows_sys::Win32::System::Memory::{
        GetProcessHeaps, HeapLock, HeapUnlock, HeapWalk, PROCESS_HEAP_ENTRY,
    };
    use windows_sys::Win32::System::SystemServices::PROCESS_HEAP_ENTRY_BUSY;

    /// The granularity of heaps of 64-bit processes, and the size of a block's header, in bytes.
    const HEAP_UNIT: usize = 16;

    /// Returns the identifiers of this process's threads, if the system lists them.
    pub(crate) fn thread_ids() -> Option<Vec<u32>> {
        // SAFETY: the process is ignored for threads: those of all processes are listed.
        let snapshot = unsafe { CreateToolhelp32Snapshot(TH32CS_SNAPTHREAD, 0) };
        if snapshot == INVALID_HANDLE_VALUE {
            return None;
        }
        // SAFETY: the handle is valid and belongs to this function.
        let snapshot = unsafe { OwnedHandle::from_raw_handle(snapshot) };
        let mut entry = THREADENTRY32 {
            dwSize: size_of::<THREADENTRY32>() as u32,
            ..Default::default()
        };
        let process = std::process::id();
        let mut ids = Vec::new();
        // SAFETY: the handle is that of a snapshot, and the entry states its size.
        let mut is_entry = unsafe { Thread32First(snapshot.as_raw_handle(), &raw mut entry) };
        while is_entry != 0 {
            if entry.th32OwnerProcessID == process {
                ids.push(entry.th32ThreadID);
            }
            // SAFETY: as above.
            is_entry = unsafe { Thread32Next(snapshot.as_raw_handle(), &raw mut entry) };
        }
        Some(ids)
    }

    /// Returns the bytes allocated on all heaps of this process, with the headers of their blocks.
    pub(crate) fn allocated_bytes() -> Option<usize> {
        let mut heaps: Vec<HANDLE> = Vec::new();
        loop {
            let room = u32::try_from(heaps.len()).ok()?;
            // SAFETY: there is room for so many handles.
            let count = unsafe { GetProcessHeaps(room, heaps.as_mut_ptr()) } as usize;
            if count == 0 {
                return None;
            }
            let is_complete = count <= heaps.len();
            heaps.resize(count, std::ptr::null_mut());
            if is_complete {
                return heaps.into_iter().map(allocated_on).sum();
            }
        }
    }

    /// Returns the bytes allocated on a heap, if it can be walked.
    fn allocated_on(heap: HANDLE) -> Option<usize> {
        // SAFETY: a heap of this process.
        if unsafe { HeapLock(heap) } == 0 {
            return None;
        }
        let mut entry = PROCESS_HEAP_ENTRY::default();
        let mut bytes = 0;
        // SAFETY: the heap is locked. The walk begins with an empty entry and goes on from the one before.
        while unsafe { HeapWalk(heap, &raw mut entry) } != 0 {
            if u32::from(entry.wFlags) & PROCESS_HEAP_ENTRY_BUSY != 0 {
                // The bytes that were asked for may be fewer than those of the smallest block.
                bytes += (entry.cbData as usize).next_multiple_of(HEAP_UNIT) + HEAP_UNIT;
            }
        }
        // SAFETY: locked above.
        unsafe { HeapUnlock(heap) };
        Some(bytes)
    }

    /// Lets a crash end this process at once, instead of a dialog that waits for a click.
    pub(crate) fn disable_error_dialogs() {
        // SAFETY: changes a setting of this process.
        unsafe { SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX) };
    }
}

#[cfg(not(any(target_os = "linux", windows)))]
mod system {
    /// Returns nothing: this host does not know how the system lists threads.
    pub(crate) fn thread_ids() -> Option<Vec<u32>> {
        None
    }

    /// Returns nothing: this host does not know how the system counts allocated memory.
    pub(crate) fn allocated_bytes() -> Option<usize> {
        None
    }

    /// Does nothing: a crash ends the process at once.
    pub(crate) fn disable_error_dialogs() {}
}

#[cfg(all(test, any(target_os = "linux", windows)))]
mod tests {
    use super::*;

    #[test]
    fn a_thread_is_listed_while_it_runs() {
        let before = thread_ids().expect("threads are listed");
        let (end, wait) = std::sync::mpsc::channel::<()>();
        let thread = std::thread::spawn(move || wait.recv());
        let during = thread_ids().expect("threads are listed");
        // Other tests may begin and end threads meanwhile.
        assert!(during.iter().any(|id| !before.contains(id)));
        drop(end);
        assert!(thread.join().expect("no panic").is_err());
    }
}
