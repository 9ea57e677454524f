// The wiring problem as the kernel sees it: tables of integers, filled by Python.
//
// Only wires that are not yet fixed appear. Times are in ticks, positions in mm, both integer. An
// end of a wire is 0 (a) or 1 (b). remodel_tasks/core/problem explains the names.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "ranking.hpp"

namespace remodel {

enum Stage : std::int32_t { kStored, kHeld, kFirstIn, kHalf, kGiven, kRouted, kSecondIn };

// How a wire is done: which arm starts with which end, and whether it hands over to the other arm.
struct Mode {
  static int of(int arm, int first, bool hands_over) { return arm * 4 + first * 2 + hands_over; }
  static int arm(int mode) { return mode >> 2; }
  static int first(int mode) { return (mode >> 1) & 1; }
  static bool hands_over(int mode) { return mode & 1; }
};

extern "C" {

// Must agree, field by field, with WiringTables in edge/search_kernel.py.
struct WiringTables {
  std::int32_t wires, components, segments, arms, unders, pins, softs, rankings, openings;
  std::int32_t speed;                                                // [mm/tick]
  std::int32_t locate, change_tool, extract, hand_over;              // [tick]
  std::int32_t colour_weight, zone_weight, start_weight, tool_weight, heavy_weight, arm_weight;
  std::int32_t cable_weight;
  std::int32_t light_started;            // a wire that is not heavy was picked before
  const std::int32_t* slot;              // (wires, 2) [mm]
  const std::int32_t* end_position;      // (wires, 2, 2) [mm]
  const std::int32_t* end_component;     // (wires, 2)
  const std::int32_t* tool;              // (wires)
  const std::int32_t* colour;            // (wires)
  const std::int32_t* cable;             // (wires) of which it is a core, or -1
  const std::int32_t* zone;              // (wires)
  const std::int32_t* heavy;             // (wires) 0 or 1
  const std::int32_t* pick;              // (wires) [tick]
  const std::int32_t* insert;            // (wires, 2) [tick]
  const std::int32_t* fix;               // (wires) [tick]
  const std::int32_t* route;             // (wires) [tick]
  const std::int32_t* handover;          // (wires, 2) [mm]
  const std::int32_t* handover_route;    // (wires, 2) [tick] between each end and the handover
  const std::int32_t* preferred_arm;     // (wires) or -1
  const std::int32_t* modes;             // (wires) bit m is set where Mode m is possible
  const std::int32_t* stage;             // (wires) Stage
  const std::int32_t* jammed;            // (wires) end, or -1
  const std::int32_t* segment_start;     // (wires + 1) into segment
  const std::int32_t* segment;           // duct segments of each wire
  const std::int32_t* under;             // (unders, 2) before, after
  const std::int32_t* pin;               // (pins, 4) before, its end, after, its end
  const std::int32_t* soft;              // (softs, 3) before, after, weight
  const std::int32_t* rank;              // (rankings, wires) or -1
  const std::int32_t* rank_weight;       // (rankings)
  const std::int32_t* opening;           // (openings) wires that come first, in this order
  const std::int32_t* located;           // (components) 0 or 1
  const std::int32_t* arm_position;      // (arms, 2) [mm]
  const std::int32_t* arm_station;       // (arms, 2) [mm]
  const std::int32_t* arm_tool;          // (arms)
  const std::int32_t* arm_colour;        // (arms) of the wire picked last, or -1
  const std::int32_t* arm_cable;         // (arms) of the wire picked last, or -1
  const std::int32_t* arm_zone;          // (arms) of the wire picked last
};

}  // extern "C"

struct Point {
  int x, y;
};

struct End {
  int wire, end;
};

struct SoftConstraint {
  int wire, weight;
};

// The tables with the relations that the search asks for, indexed by wire.
class Problem {
 public:
  explicit Problem(const WiringTables& tables);

  // What it costs to pick a wire after one of that cable, or of none (-1).
  int cable_penalty(int last, int wire) const {
    return t.cable_weight * (t.cable[wire] >= 0 && t.cable[wire] != last);
  }

  int travel(Point from, Point to) const {
    const int distance = std::max(std::abs(from.x - to.x), std::abs(from.y - to.y));
    return (distance + t.speed - 1) / t.speed;
  }
  Point slot(int wire) const { return {t.slot[2 * wire], t.slot[2 * wire + 1]}; }
  Point end(int wire, int end) const {
    return {t.end_position[4 * wire + 2 * end], t.end_position[4 * wire + 2 * end + 1]};
  }
  Point handover(int wire) const { return {t.handover[2 * wire], t.handover[2 * wire + 1]}; }
  Point station(int arm) const { return {t.arm_station[2 * arm], t.arm_station[2 * arm + 1]}; }
  Point start(int arm) const { return {t.arm_position[2 * arm], t.arm_position[2 * arm + 1]}; }
  int component(int wire, int end) const { return t.end_component[2 * wire + end]; }
  bool has_mode(int wire, int mode) const { return t.modes[wire] >> mode & 1; }
  bool ducts_shared(int wire, int other) const {
    return shared_[static_cast<std::size_t>(wire) * words_ + other / 64] >> (other % 64) & 1;
  }

  const WiringTables t;
  std::vector<std::vector<int>> before, after;    // wires that must be done before, after
  std::vector<std::vector<int>> under;            // wires that must be routed before
  std::vector<std::vector<End>> pins[2];          // ends that must be in before this end
  std::vector<std::vector<SoftConstraint>> soft_before;   // wires whose pick should come before
  std::vector<std::vector<SoftConstraint>> soft_after;    // wires whose pick should come after
  std::vector<std::vector<End>> ends_at;          // by component
  std::vector<Ranking> rankings;

 private:
  void find_shared_ducts();

  int words_ = 0;
  std::vector<std::uint64_t> shared_;
};

}  // namespace remodel
