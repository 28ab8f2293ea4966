// Files read whole and written whole or not at all (temporary name in the same folder, fsync, rename).
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace likeness {

// Whether there is an accessible file or folder of that name.
bool path_exists(const std::filesystem::path& path);

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path);
Result<std::string> read_text(const std::filesystem::path& path);

// Creates missing parent folders. A full disk, a read-only folder or a missing permission becomes an Error
// with the remedy; on any failure the old file, if there was one, is untouched and no temporary file remains.
Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
Result<void> write_text(const std::filesystem::path& path, std::string_view text);

// Makes the folder and checks that a file can be created in it.
Result<void> make_writable_folder(const std::filesystem::path& folder);

// The name to write to before commit_file() renames it into place; in the same folder, same extension, unique
// to this process. For writers that insist on a path (encoders, image libraries).
std::filesystem::path temporary_name(const std::filesystem::path& path);
Result<void> commit_file(const std::filesystem::path& temporary, const std::filesystem::path& path);

// Error for a failed system call on a path, from errno: says what happened and what the user can do.
Error file_error(const std::filesystem::path& path, std::string_view action, int error_number);

}  // namespace likeness
