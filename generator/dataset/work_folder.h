// .work, as far as it is ours, removed.
//
//   remove_work_folder  remove_work_of  remove_temporary_files
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace ensonify {

// Removes the records, plans and temporary files of .work, then the folders that are empty.
// Another process may do the same at the same time. A stranger's file in it stays.
void remove_work_folder(const std::filesystem::path& dir);
// The same of some sequences, while others may be at work on theirs: temporary files stay.
void remove_work_of(const std::filesystem::path& dir, std::span<const std::uint32_t> sequences);
// Those of processes that were killed; one that is still at work writes its own again.
void remove_temporary_files(const std::filesystem::path& dir);

}  // namespace ensonify
