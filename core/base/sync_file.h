// What was written goes to the disk.
#pragma once

namespace likeness {

// 0, or errno. Shares and other file systems that do not know how keep the file all the same: no failure.
int sync_file(int descriptor);

}  // namespace likeness
