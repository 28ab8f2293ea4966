// The keyboard's way through a window: Tab goes from one thing that can be pressed to the next, over all
// panels, in the order in which they are drawn; F10 goes to the menus. ImGui itself stops at fields that are
// typed in and at the edge of every panel.
#pragma once

namespace likeness::ui {

void forget_reachable();    // at the start of a frame
void note_reachable();      // the item drawn last; one that is disabled is passed over
void note_first_menu();     // the item drawn last: where F10 leads
void walk_by_keyboard();    // at the end of a frame
void scroll_by_keys();      // the window that is being drawn, by arrow and page keys, Home and End
bool keyboard_is_at_it();   // at the item drawn last, and it shows
void draw_keyboard_ring();  // about the item drawn last, for one that ImGui draws nothing of

}  // namespace likeness::ui
