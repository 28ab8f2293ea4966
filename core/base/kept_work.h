// Pieces of long work, kept in one file as they are finished, so that the same work goes on where it was
// killed.
//
// Only a copy: what cannot be kept, or read again, is made again.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace likeness {

class KeptWork {
 public:
  // file: of no other work at the same time; its folder is made. inputs: all that the pieces depend on
  // besides their names; a file of others begins anew, and what follows a piece that was cut short is
  // dropped.
  KeptWork(std::filesystem::path file, const std::string& inputs);
  ~KeptWork();
  KeptWork(const KeptWork&) = delete;
  KeptWork& operator=(const KeptWork&) = delete;

  // Both from any thread. A piece that is kept outlives this process at once, and the machine half a minute
  // later.
  std::optional<std::string> find(const std::string& name) const;
  void keep(const std::string& name, std::string_view bytes);
  // The work is done: removes the file.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace likeness
