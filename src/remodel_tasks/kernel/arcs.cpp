#include "arcs.hpp"

#include <limits>

namespace remodel {
namespace {

// From a position to the slot of a wire, with the tool that it needs.
int reach(const Problem& p, int arm, Point from, int tool, int wire) {
  if (tool == p.t.tool[wire]) return p.travel(from, p.slot(wire));
  const Point station = p.station(arm);
  return p.travel(from, station) + p.t.change_tool + p.travel(station, p.slot(wire)) +
         p.t.tool_weight;
}

// The ways of a wire that depend on its first end: up to that end, before the insertion.
int approach(const Problem& p, int arm, int wire, int first) {
  switch (p.t.stage[wire]) {
    case kStored: return p.travel(p.slot(wire), p.end(wire, first));
    case kHeld: {
      const Point at = p.start(arm), end = p.end(wire, first);
      if (p.t.jammed[wire] < 0) return p.travel(at, end);
      const Point jam = p.end(wire, p.t.jammed[wire]);
      return p.travel(at, jam) + p.travel(jam, end);
    }
    default: return 0;   // The ways left are the same whatever follows.
  }
}


// Penalties when one arm picks wire j after wire i.
int pair_penalty(const Problem& p, int i, int j) {
  return p.cable_penalty(p.t.cable[i], j) + p.t.colour_weight * (p.t.colour[i] != p.t.colour[j]) +
         p.t.zone_weight * std::max(0, p.t.zone[i] - p.t.zone[j]);
}

int begin(const Problem& p, int arm, int j) {
  int cost = reach(p, arm, p.start(arm), p.t.arm_tool[arm], j) + p.cable_penalty(p.t.arm_cable[arm], j);
  if (p.t.arm_colour[arm] >= 0)
    cost += p.t.colour_weight * (p.t.arm_colour[arm] != p.t.colour[j]) +
            p.t.zone_weight * std::max(0, p.t.arm_zone[arm] - p.t.zone[j]);
  else if (arm == 0)
    cost += p.t.start_weight * p.t.zone[j];
  return cost;
}

bool may_start(const Problem& p, int wire, int first) {
  const int bits = p.t.modes[wire];
  return bits & (3 << Mode::of(0, first, false) | 3 << Mode::of(1, first, false));
}

}  // namespace

int Arcs::follow(const Problem& p, int arm, int i, int j, int* first) {
  const int n = p.t.wires;
  if (i == n) return j == n ? 0 : p.t.stage[j] == kStored ? begin(p, arm, j) : 0;
  int best = std::numeric_limits<int>::max();
  for (int d = 0; d < 2; ++d) {
    if (!may_start(p, i, d)) continue;
    int cost = approach(p, arm, i, d);
    if (j < n) cost += reach(p, arm, p.end(i, 1 - d), p.t.tool[i], j);
    if (cost < best) {
      best = cost;
      *first = d;
    }
  }
  return j < n ? best + pair_penalty(p, i, j) : best;
}

Arcs::Arcs(const Problem& problem, int arm)
    : p_(problem), arm_(arm), size_(problem.t.wires + 1),
      cost_(static_cast<std::size_t>(size_) * size_) {
  const int n = p_.t.wires;
  std::vector<Point> slots(n);
  std::vector<int> from_station(n);
  for (int j = 0; j < n; ++j) {
    slots[j] = p_.slot(j);
    from_station[j] = p_.travel(p_.station(arm), slots[j]) + p_.t.change_tool + p_.t.tool_weight;
  }
  for (int i = 0; i < n; ++i) {
    int* row = cost_.data() + static_cast<std::size_t>(i) * size_;
    std::fill(row, row + size_, std::numeric_limits<int>::max());
    for (int d = 0; d < 2; ++d) {
      if (!may_start(p_, i, d)) continue;
      const Point end = p_.end(i, 1 - d);
      const int near = approach(p_, arm, i, d);
      const int away = near + p_.travel(end, p_.station(arm));
      for (int j = 0; j < n; ++j) {
        const int way = p_.t.tool[i] == p_.t.tool[j] ? near + p_.travel(end, slots[j])
                                                     : away + from_station[j];
        row[j] = std::min(row[j], way);
      }
      row[n] = std::min(row[n], near);
    }
    for (int j = 0; j < n; ++j) row[j] += pair_penalty(p_, i, j);
  }
  int unused = 0;
  for (int j = 0; j <= n; ++j) cost_[static_cast<std::size_t>(n) * size_ + j] = follow(p_, arm, n, j, &unused);
}

int Arcs::first_end(int i, int j) const {
  int first = 0;
  follow(p_, arm_, i, j, &first);
  return first;
}

}  // namespace remodel
