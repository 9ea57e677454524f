#include "order.hpp"

#include <queue>

#include "arcs.hpp"

namespace remodel {
namespace {

int likely_mode(const Problem& p, int wire) {
  const int preferred = p.t.preferred_arm[wire];
  for (int mode = 0; mode < 8; ++mode)
    if (p.has_mode(wire, mode) && Mode::arm(mode) == preferred) return mode;
  int mode = 0;
  while (!p.has_mode(wire, mode)) ++mode;
  return mode;
}

// Write the wires in the order of their places, as far as the order constraints let them.
void sort(const Problem& p, const std::vector<int>& place, int* order) {
  using Item = std::pair<int, int>;   // place, wire
  std::priority_queue<Item, std::vector<Item>, std::greater<Item>> ready;
  std::vector<int> waiting(p.t.wires);
  for (int wire = 0; wire < p.t.wires; ++wire) {
    waiting[wire] = static_cast<int>(p.before[wire].size());
    if (!waiting[wire]) ready.emplace(place[wire], wire);
  }
  for (int count = 0; !ready.empty(); ++count) {
    const int wire = ready.top().second;
    ready.pop();
    order[count] = wire;
    for (int next : p.after[wire])
      if (!--waiting[next]) ready.emplace(place[next], next);
  }
}

// Whether no arm has anything to do before the wire in its hand.
bool held_come_first(const Problem& p, const int* order, const int* modes) {
  bool busy[2] = {};
  for (int i = 0; i < p.t.wires; ++i) {
    const int wire = order[i], arm = Mode::arm(modes[wire]);
    if (p.t.stage[wire] != kStored && busy[arm]) return false;
    busy[arm] = true;
    if (Mode::hands_over(modes[wire])) busy[1 - arm] = true;
  }
  return true;
}

void choose_first_ends(const Problem& p, const int* order, int* modes) {
  const int n = p.t.wires;
  for (int i = 0; i < n; ++i) {
    int first = 0;
    Arcs::follow(p, 0, order[i], i + 1 < n ? order[i + 1] : n, &first);
    modes[order[i]] = Mode::of(0, first, false);
  }
}

}  // namespace

void follow_ranks(const Problem& p, const int* rank, bool opening_first, int* order, int* modes) {
  for (int wire = 0; wire < p.t.wires; ++wire) {
    if (p.t.arms == 1)
      modes[wire] = 0;
    else if (modes[wire] < 0 || !p.has_mode(wire, modes[wire]))
      modes[wire] = likely_mode(p, wire);
  }
  std::vector<int> place(rank, rank + p.t.wires);
  sort(p, place, order);
  if (opening_first || !held_come_first(p, order, modes)) {
    for (int i = 0; i < p.t.openings; ++i) place[p.t.opening[i]] = i - p.t.openings;
    sort(p, place, order);
  }
  if (p.t.arms == 1) choose_first_ends(p, order, modes);
}

}  // namespace remodel
