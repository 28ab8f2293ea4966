// Files read whole and written whole or not at all (temporary name in the same folder, fsync, rename).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace likeness {

// Whether there is an accessible file or folder of that name.
bool path_exists(const std::filesystem::path& path);

// Of plain files alone: a pipe or a device may never end. `most`: a larger file is an Error before any of it
// is read.
inline constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 32, kLargestText = std::uint64_t{1} << 31;
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path,
                                         std::uint64_t most = kLargestFile);
Result<std::string> read_text(const std::filesystem::path& path, std::uint64_t most = kLargestText);
// Its first bytes, at most so many.
Result<std::vector<std::byte>> read_head(const std::filesystem::path& path, std::size_t most);
// An Error where it is a pipe, a socket or a device, whose reading may never end; links followed. For readers
// of libraries, which open by path.
Result<void> check_not_endless(const std::filesystem::path& path);

// Creates missing parent folders. A full disk, a read-only folder or a missing permission becomes an Error
// with the remedy; on any failure the old file, if there was one, is untouched and no temporary file remains.
Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
Result<void> write_text(const std::filesystem::path& path, std::string_view text);

// Makes the folder and checks that a file can be created in it.
Result<void> make_writable_folder(const std::filesystem::path& folder);

// The name to write to before commit_file() renames it into place; in the same folder, same extension, unique
// to this process and not to be guessed: .NAME.PID-NUMBER.part.EXTENSION. For writers that insist on a path
// (encoders, image libraries).
std::filesystem::path temporary_name(const std::filesystem::path& path);
// Whether a name has exactly that form; a user's own hidden files hardly do.
bool is_part_name(const std::string& name);
// Removes what killed processes left half-written in a folder: parts, whose process no longer lives. of: only
// those whose NAME this is; empty: all.
void remove_abandoned_parts(const std::filesystem::path& folder, std::string_view of = {});
Result<void> commit_file(const std::filesystem::path& temporary, const std::filesystem::path& path);

// Error for a failed system call on a path, from errno: says what happened and what the user can do.
Error file_error(const std::filesystem::path& path, std::string_view action, int error_number);

}  // namespace likeness
