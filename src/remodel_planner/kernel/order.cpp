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

}  // namespace

void follow_ranks(const Problem& p, const int* rank, int* order, int* modes) {
  using Item = std::pair<int, int>;   // rank, wire
  std::priority_queue<Item, std::vector<Item>, std::greater<Item>> ready;
  std::vector<int> waiting(p.t.wires), place(p.t.wires);
  for (int wire = 0; wire < p.t.wires; ++wire) place[wire] = rank[wire];
  for (int i = 0; i < p.t.openings; ++i) place[p.t.opening[i]] = i - p.t.openings;
  for (int wire = 0; wire < p.t.wires; ++wire) {
    if (p.t.arms > 1 && (modes[wire] < 0 || !p.has_mode(wire, modes[wire])))
      modes[wire] = likely_mode(p, wire);
    else if (p.t.arms == 1)
      modes[wire] = 0;
    waiting[wire] = static_cast<int>(p.before[wire].size());
  }
  for (int wire = 0; wire < p.t.wires; ++wire)
    if (!waiting[wire]) ready.emplace(place[wire], wire);
  int count = 0;
  while (!ready.empty()) {
    const int wire = ready.top().second;
    ready.pop();
    order[count++] = wire;
    for (int next : p.after[wire])
      if (!--waiting[next]) ready.emplace(place[next], next);
  }
  if (p.t.arms > 1) return;
  for (int i = 0; i < count; ++i) {
    int first = 0;
    Arcs::follow(p, 0, order[i], i + 1 < count ? order[i + 1] : p.t.wires, &first);
    modes[order[i]] = Mode::of(0, first, false);
  }
}

}  // namespace remodel
