// The lists.
#include "core/holds/asked.h"

namespace likeness {

const std::vector<AskedView>& asked_views() {
  static const std::vector<AskedView> views{{0, 0},  {-15, 0}, {15, 0}, {-30, 0}, {30, 0}, {-45, 0},
                                            {45, 0}, {0, -15}, {0, 15}, {0, -25}, {0, 25}};
  return views;
}

const std::vector<AskedAction>& asked_actions() {
  static const std::vector<AskedAction> all = [] {
    std::vector<AskedAction> list;
    for (const char* name : {"jawOpen", "mouthSmile", "mouthPucker", "mouthFunnel", "mouthFrown", "eyeBlink",
                             "browInnerUp", "browDown", "jawLeft", "noseSneer"})
      for (const float amount : {0.5f, 1.0f}) list.push_back({name, {name}, amount});
    list.push_back({"jawOpen+browInnerUp", {"jawOpen", "browInnerUp"}, 1});
    list.push_back({"jawOpen+mouthSmile", {"jawOpen", "mouthSmile"}, 1});
    list.push_back({"mouthSmile+eyeBlink", {"mouthSmile", "eyeBlink"}, 1});
    list.push_back({"mouthPucker+browDown", {"mouthPucker", "browDown"}, 1});
    return list;
  }();
  return all;
}

std::vector<const NamedAction*> sides_of(const HeadModel& model, const std::string& action) {
  std::vector<const NamedAction*> found;
  for (const char* side : {"", "_L", "_R"})
    if (const NamedAction* own = find_action(model, action + side)) found.push_back(own);
  return found;
}

void perform_asked(const HeadModel& model, const AskedAction& asked, Articulation& articulation) {
  for (const std::string& name : asked.actions)
    for (const NamedAction* action : sides_of(model, name)) add_action(articulation, *action, asked.amount);
}

}  // namespace likeness
