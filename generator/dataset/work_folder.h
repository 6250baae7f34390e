// Removes our files in .work.
//
//   remove_work_folder  remove_work_of  remove_temporary_files
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace ensonify {

// Removes the records, plans and temporary files of .work, then the folders that are empty. Another
// process may do the same at the same time. Foreign files in it stay.
void remove_work_folder(const std::filesystem::path& dir);
// The same for some sequences, while other processes may work on theirs: temporary files stay.
void remove_work_of(const std::filesystem::path& dir, std::span<const std::uint32_t> sequences);
// Removes those of killed processes; a process that still works writes its own again.
void remove_temporary_files(const std::filesystem::path& dir);

}  // namespace ensonify
