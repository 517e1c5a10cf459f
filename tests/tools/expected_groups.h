#pragma once

#include <array>
#include <ostream>

namespace vantage {

/// The group that an object has by what it is. What stands out or is let in by more than some 3 %
/// of the diameter breaks a symmetry; seams, pull tabs, dents and the unevenness of scans do not.
struct ExpectedGroup {
  const char* name;  ///< of a generated object, or the file of a scan
  int order;         ///< 1: none; 0: continuous
  bool flips;        ///< half turns across the axis
  const char* why;

  /// How tests are named and messages tell it.
  friend void PrintTo(const ExpectedGroup& group, std::ostream* stream) { *stream << group.name; }
};

inline constexpr std::array<ExpectedGroup, 18> kGeneratedGroups = {{
    {"filter", 1, false, "a boss of 17 mm breaks the half turn"},
    {"shampoo", 2, false, "oval body, the cap says what is up"},
    {"hub", 1, false, "a boss of 16 mm breaks the quarter turns"},
    {"trefoil", 3, false, "three lobes, top and bottom differ"},
    {"carton", 2, true, "a brick"},
    {"bottle", 0, false, "turned, with a neck"},
    {"mug", 1, false, "one handle"},
    {"bracket", 1, false, "unequal plates"},
    {"gear", 6, false, "six teeth, a hub on one side"},
    {"duck", 1, false, "an animal"},
    {"cat", 1, false, "an animal"},
    {"dwarf", 1, false, "a figure with one hand raised"},
    {"fish", 1, false, "left and right mirror each other, which is no rotation"},
    {"pitcher", 1, false, "a lip and a handle"},
    {"pony", 1, false, "an animal"},
    {"sauce", 1, false, "a thumb rest of 12 mm breaks the half turn"},
    {"spray", 1, false, "nozzle and trigger point to one side"},
    {"turtle", 1, false, "left and right mirror each other, which is no rotation"},
}};

inline constexpr std::array<ExpectedGroup, 26> kScanGroups = {{
    {"apc_folgers_classic_roast_coffee.obj", 0, true, "modeled as a cylinder"},
    {"apc_scotch_duct_tape.obj", 0, true, "a ring"},
    {"apc_up_glucose_bottle.obj", 0, false, "round, the neck says what is up"},
    {"icbin_coffee_cup.ply", 0, false, "a tapered cup with a lid, whose dents are the scan's"},
    {"kit_CatLying_800.obj", 1, false, "an animal"},
    {"kit_ChoppedTomatoes_800.obj", 0, true, "a can with a rim at both ends"},
    {"kit_Clown_800.obj", 1, false, "a figure"},
    {"kit_Dwarf_800.obj", 1, false, "a figure"},
    {"kit_HamburgerSauce_800.obj", 2, false, "oval bottle with a cap"},
    {"kit_Pitcher_800.obj", 1, false, "a lip and a handle"},
    {"kit_Shampoo_800.obj", 2, false, "oval bottle with a shoulder"},
    {"kit_Sprayflask_800.obj", 1, false, "nozzle and trigger point to one side"},
    {"kit_TomatoSauce_800.obj", 2, true, "a carton; seam and ears are folded flat"},
    {"mian_chef.ply", 1, false, "a figure"},
    {"mian_parasaurolophus.ply", 1, false, "an animal"},
    {"stanford_bunny.ply", 1, false, "an animal"},
    {"ycb_Banana.obj", 1, false, "a stem at one end"},
    {"ycb_CrackerBox.obj", 2, true, "a carton with bulging sides"},
    {"ycb_FoamBrick.obj", 2, false, "three deep holes in the top"},
    {"ycb_GelatinBox.obj", 2, true, "a carton"},
    {"ycb_MasterChefCan.obj", 0, true, "a can; lid and bottom differ by 1 % at most"},
    {"ycb_MustardBottle.obj", 2, false, "oval bottle with a round cap"},
    {"ycb_PottedMeatCan.obj", 2, false, "a wide rim and a sunk lid on top, the bottom round"},
    {"ycb_PowerDrill.obj", 1, false, "a drill"},
    {"ycb_Scissors.obj", 1, false, "one loop is round, the other oval"},
    {"ycb_TomatoSoupCan.obj",
     0,
     false,
     "the lid is sunk 4 mm into its rim, the bottom's edge round"},
}};

}  // namespace vantage
