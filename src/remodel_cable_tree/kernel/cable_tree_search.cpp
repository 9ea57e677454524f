#include "cable_tree_search.hpp"

#include <algorithm>

namespace remodel {

CableTreeSearch::CableTreeSearch(const CableTree& tree, const Precedence& known, const int* order,
                                 std::uint64_t seed)
    : tree_(tree), known_(known), random_(seed), k_(tree.t.ends), order_(order, order + k_),
      place_(k_), best_(order_), breaks_(tree.t.disjunctives) {
  return_to_best();
  best_cost_ = cost_.total(k_);
}

void CableTreeSearch::return_to_best() {
  order_ = best_;
  for (int i = 0; i < k_; ++i) place_[order_[i]] = i;
  for (int end = 0; end < k_; ++end) recount_disjunctions(end);
  cost_.soft = 0;
  for (int i = 0; i < tree_.t.softs; ++i)
    cost_.soft += place_[tree_.t.soft[2 * i]] > place_[tree_.t.soft[2 * i + 1]];
  count_order();
}

void CableTreeSearch::recount_disjunctions(int end) {
  for (int i : tree_.disjunctives_of[end]) {
    const std::int32_t* d = tree_.t.disjunctive + 4 * i;
    const char breaks = place_[d[0]] >= place_[d[1]] && place_[d[2]] >= place_[d[3]];
    broken_disjunctions_ += breaks - breaks_[i];
    breaks_[i] = breaks;
  }
}

// Count what depends on the cables: one pass over the order.
void CableTreeSearch::count_order() {
  const int b = tree_.t.cables;
  int open = 0, most = 0, stored = 0, longest = 0, broken = broken_disjunctions_;
  for (int i = 0; i < k_; ++i) {
    const int end = order_[i];
    if (end >= 2 * b) continue;
    const int other = place_[end < b ? end + b : end - b];
    if (other > i) {
      most = std::max(most, open);
      ++open;
      const int time = other - i;
      stored += time > 1;
      longest = std::max(longest, time - 1);
      broken += time > 1 && tree_.direct[end];
    } else {
      --open;
      most = std::max(most, open);
    }
  }
  cost_.broken = broken;
  cost_.stored = stored;
  cost_.open = most;
  cost_.longest = longest;
}

// Whether some of the items from .. from + count - 1 must stay behind an end, or before it.
bool CableTreeSearch::must_stay_behind(int end, int from, int count) const {
  for (int i = from; i < from + count; ++i)
    if (known_.before(end, order_[i])) return true;
  return false;
}

bool CableTreeSearch::must_stay_before(int end, int from, int count) const {
  for (int i = from; i < from + count; ++i)
    if (known_.before(order_[i], end)) return true;
  return false;
}

// The least and the greatest place that the first of some items may move to, the others following.
void CableTreeSearch::span(int from, int count, int& low, int& high) const {
  low = high = from;
  while (low > 0 && !must_stay_behind(order_[low - 1], from, count)) --low;
  while (high + count < k_ && !must_stay_before(order_[high + count], from, count)) ++high;
}

bool CableTreeSearch::propose(int& from, int& count, int& to, bool& reversed) {
  const std::uint32_t dice = random_.next();
  from = random_.below(k_);
  const int end = order_[from], other_end = tree_.other_end(end);
  const int other = other_end < 0 ? -1 : place_[other_end];
  count = 1;
  reversed = false;
  if (other >= 0 && std::abs(other - from) == 1 && (dice & 7) < 6) {
    from = std::min(from, other);
    count = 2;
    reversed = (dice >> 3 & 3) == 0 && !known_.before(order_[from], order_[from + 1]);
  } else if ((dice & 7) == 7 && other < 0 && from + 1 < k_) {
    count = std::min(k_ - from, 2 + static_cast<int>(dice >> 3) % 4);
  }
  int low, high;
  span(from, count, low, high);
  if (low == high) {
    to = from;
    return reversed;
  }
  to = low + random_.below(high - low + 1);
  if (count == 1 && other >= 0 && (dice >> 8 & 3) == 0) {
    // Beside the other end, on either side, as near as the span lets it.
    to = other > from ? other - 1 + (dice >> 10 & 1) : other + (dice >> 10 & 1);
    to = std::clamp(to, low, high);
  } else if ((dice >> 12 & 3) == 0) {
    to = std::clamp(from - 3 + random_.below(7), low, high);
  }
  return to != from || reversed;
}

void CableTreeSearch::shift(int from, int count, int to) {
  if (to < from)
    std::rotate(order_.begin() + to, order_.begin() + from, order_.begin() + from + count);
  else
    std::rotate(order_.begin() + from, order_.begin() + from + count, order_.begin() + to + count);
  for (int i = std::min(from, to); i < std::max(from, to) + count; ++i) place_[order_[i]] = i;
}

void CableTreeSearch::reverse_pair(int at) {
  std::swap(order_[at], order_[at + 1]);
  std::swap(place_[order_[at]], place_[order_[at + 1]]);
}

// The change of violated soft constraints when the items pass those between.
int CableTreeSearch::passed_soft(int from, int count, int to) const {
  const int first = to < from ? to : from + count;
  const int last = to < from ? from : to + count;
  int sum = 0;
  for (int i = from; i < from + count; ++i) {
    const std::int8_t* row = tree_.soft.data() + static_cast<std::size_t>(order_[i]) * k_;
    for (int j = first; j < last; ++j) sum += row[order_[j]];
  }
  return to > from ? sum : -sum;
}

void CableTreeSearch::anneal(std::int64_t moves, double from, double to, const Weights& w) {
  if (k_ < 2) return;
  const std::int64_t step = std::max<std::int64_t>(1, moves / 256);
  double temperature = from;
  const auto energy = [&w](const OrderCost& c) {
    return w.broken * c.broken + w.stored * c.stored + w.open * c.open + w.longest * c.longest +
           w.soft * c.soft;
  };
  for (std::int64_t i = 0; i < moves; ++i) {
    if (i % step == 0) temperature = from * std::pow(to / from, static_cast<double>(i) / moves);
    int at, count, target;
    bool reversed;
    if (!propose(at, count, target, reversed)) continue;
    const OrderCost old = cost_;
    const int soft = target == at ? 0 : passed_soft(at, count, target);
    if (target != at) shift(at, count, target);
    cost_.soft += soft;
    if (reversed) {
      cost_.soft += tree_.soft[static_cast<std::size_t>(order_[target]) * k_ + order_[target + 1]];
      reverse_pair(target);
    }
    for (int j = target; j < target + count; ++j) recount_disjunctions(order_[j]);
    count_order();
    const double loss = energy(cost_) - energy(old);
    if (loss > 0 && loss > random_.allowance(temperature)) {
      if (reversed) reverse_pair(target);
      if (target != at) shift(target, count, at);
      for (int j = at; j < at + count; ++j) recount_disjunctions(order_[j]);
      cost_ = old;
    } else if (cost_.broken == 0 && cost_.total(k_) < best_cost_) {
      best_cost_ = cost_.total(k_);
      best_ = order_;
    }
  }
}

}  // namespace remodel
