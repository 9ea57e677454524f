#include "neighbours.hpp"

#include <limits>

namespace remodel {
namespace {

// The cheapest entries seen so far, by insertion.
struct Cheapest {
  int count = 0, cost[Neighbours::kCount], wire[Neighbours::kCount];

  void offer(int new_cost, int new_wire, int limit) {
    if (count == limit && new_cost >= cost[count - 1]) return;
    int at = count < limit ? count++ : count - 1;
    for (; at > 0 && cost[at - 1] > new_cost; --at) {
      cost[at] = cost[at - 1];
      wire[at] = wire[at - 1];
    }
    cost[at] = new_cost;
    wire[at] = new_wire;
  }
};

}  // namespace

Neighbours::Neighbours(const Arcs& arcs) {
  const int n = arcs.size() - 1;
  count_ = std::max(1, std::min(kCount, n - 1));
  std::vector<Cheapest> before(n), after(n);
  for (int i = 0; i < n; ++i) {
    const int* row = arcs.row(i);
    for (int j = 0; j < n; ++j) {
      if (i == j && n > 1) continue;
      after[i].offer(row[j], j, count_);
      before[j].offer(row[j], i, count_);
    }
  }
  for (int i = 0; i < n; ++i) {
    before_.insert(before_.end(), before[i].wire, before[i].wire + count_);
    after_.insert(after_.end(), after[i].wire, after[i].wire + count_);
  }
}

}  // namespace remodel
