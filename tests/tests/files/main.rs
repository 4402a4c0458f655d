//! Files: what is written is read again, by us and by programs that we did not write.

mod export;
mod export_formats;
mod flags;
mod forms;
mod session_file;
mod studio_files;
mod tool_files;
mod whole_file;
