// Claims about the file browser: what of a folder it shows.
#include "ui/studio/folder_list.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names(const std::vector<FolderEntry>& entries) {
  std::vector<std::string> names;
  for (const FolderEntry& entry : entries) names.push_back(entry.name);
  return names;
}

TEST(ListFolder, ShowsProjectsFoldersAndClips) {
  std::string name = (fs::temp_directory_path() / "likeness_browser_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path folder = name;
  for (const char* file : {"b.MP4", "a.mov", "notes.txt", "wall.JPG", "keys.json", ".hidden.mp4",
                           "z.likeness/project.json", "film/x.mp4"})
    ASSERT_TRUE(write_text(folder / file, "x").ok());
  EXPECT_EQ(names(list_folder(folder, Wanted::clip)),
            (std::vector<std::string>{"z.likeness", "film", "a.mov", "b.MP4"}));
  EXPECT_EQ(names(list_folder(folder, Wanted::project)), (std::vector<std::string>{"z.likeness", "film"}));
  // Performances, but not the files that make up a project.
  ASSERT_TRUE(write_text(folder / "track.json", "x").ok());
  for (const Wanted wanted : {Wanted::performance, Wanted::new_performance, Wanted::export_performance})
    EXPECT_EQ(names(list_folder(folder, wanted)),
              (std::vector<std::string>{"z.likeness", "film", "keys.json"}));
  for (const Wanted wanted : {Wanted::driver, Wanted::driving_clip, Wanted::moved_clip})
    EXPECT_EQ(names(list_folder(folder, wanted)), names(list_folder(folder, Wanted::clip)));
  EXPECT_EQ(names(list_folder(folder, Wanted::background)),
            (std::vector<std::string>{"z.likeness", "film", "wall.JPG"}));
  EXPECT_TRUE(list_folder(folder / "absent", Wanted::clip).empty());
  fs::remove_all(folder);
}

}  // namespace
}  // namespace likeness::ui
