#include "one_arm_search.hpp"

#include <limits>
#include <set>

#include "cables.hpp"

namespace remodel {
namespace {
// More than any wire costs that may come first.
constexpr Cost kNotYet = Cost{1} << 60;
}  // namespace

OneArmSearch::OneArmSearch(const Problem& problem, std::uint64_t seed)
    : p_(problem), arcs_(problem, 0), random_(seed), n_(problem.t.wires), low_(1 + problem.t.openings) {}

bool OneArmSearch::construct() {
  std::set<int> tools;
  for (int wire = 0; wire < n_; ++wire)
    if (p_.t.stage[wire] == kStored) tools.insert(p_.t.tool[wire]);
  if (tools.empty()) tools.insert(-1);
  Cost least = std::numeric_limits<Cost>::max();
  std::vector<int> chosen;
  for (int tool : tools)
    for (int surcharge : {0, p_.t.heavy_weight, 10 * p_.t.heavy_weight})
      for (int by_rank = 0; by_rank <= !p_.rankings.empty(); ++by_rank) {
        std::vector<int> order = greedy(tool, surcharge, by_rank);
        const Cost cost = cost_of(order.data());
        if (cost < least) {
          least = cost;
          chosen.swap(order);
        }
      }
  return adopt(chosen.data(), nullptr);
}

// Always the cheapest wire that may come next; the first one, if possible, with a given tool.
std::vector<int> OneArmSearch::greedy(int first_tool, int light_surcharge, bool by_rank) const {
  std::vector<int> order, ready, waiting(n_);
  std::vector<Cost> delays(n_);
  if (by_rank)
    for (const Ranking& ranking : p_.rankings) ranking.add_delays(delays);
  order.reserve(n_);
  for (int wire = 0; wire < n_; ++wire) {
    waiting[wire] = static_cast<int>(p_.before[wire].size());
    if (!waiting[wire]) ready.push_back(wire);
  }
  BegunCables cables(p_);
  int last = n_;
  bool light = p_.t.light_started;
  while (!ready.empty()) {
    std::size_t at = 0;
    Cost least = std::numeric_limits<Cost>::max();
    for (std::size_t i = 0; i < ready.size(); ++i) {
      const int wire = ready[i];
      const int cable = last < n_ ? p_.t.cable[last] : p_.t.arm_cable[0];
      Cost cost = arcs_.cost(last, wire) + delays[wire] - p_.cable_penalty(cable, wire) +
                 cables.penalty(0, cable, wire);
      if (!light && !p_.t.heavy[wire]) cost += light_surcharge;
      if (static_cast<int>(order.size()) == p_.t.openings && p_.t.tool[wire] != first_tool)
        cost += kNotYet;
      if (static_cast<int>(order.size()) < p_.t.openings)
        cost = -(wire == p_.t.opening[order.size()]);
      if (cost < least) {
        least = cost;
        at = i;
      }
    }
    const int wire = last = ready[at];
    ready[at] = ready.back();
    ready.pop_back();
    light = light || !p_.t.heavy[wire];
    order.push_back(wire);
    cables.take(wire);
    if (by_rank)
      for (const Ranking& ranking : p_.rankings) ranking.take_off_delays(wire, delays);
    for (int next : p_.after[wire])
      if (!--waiting[next]) ready.push_back(next);
  }
  return order;
}

bool OneArmSearch::adopt(const int* order, const int*) {
  std::vector<int> sequence(n_ + 2, n_);
  std::copy(order, order + n_, sequence.begin() + 1);
  reset(sequence);
  best_ = sequence_;
  best_cost_ = cost_;
  return true;
}

void OneArmSearch::best(int* order, int* modes) const {
  for (int i = 1; i <= n_; ++i) {
    order[i - 1] = best_[i];
    modes[best_[i]] = Mode::of(0, arcs_.first_end(best_[i], best_[i + 1]), false);
  }
}

void OneArmSearch::return_to_best() { reset(std::vector<int>(best_)); }

void OneArmSearch::reset(const std::vector<int>& sequence) {
  sequence_ = sequence;
  position_.resize(n_);
  first_light_ = p_.t.light_started ? 0 : n_ + 1;
  for (int i = n_; i >= 1; --i) {
    position_[sequence_[i]] = i;
    if (!p_.t.light_started && !p_.t.heavy[sequence_[i]]) first_light_ = i;
  }
  ranked_.assign(p_.rankings.size(), std::vector<int>(n_ + 2, -1));
  for (std::size_t k = 0; k < ranked_.size(); ++k)
    for (int i = 1; i <= n_; ++i) ranked_[k][i] = p_.rankings[k].of(sequence_[i]);
  cost_ = cost_of(sequence_.data() + 1);
}

Cost OneArmSearch::cost_of(const int* order) const {
  std::vector<char> picked(n_);
  bool light = p_.t.light_started;
  Cost cost = 0;
  int last = n_;
  for (int i = 0; i < n_; ++i) {
    const int wire = order[i];
    cost += arcs_.cost(last, wire);
    picked[wire] = 1;
    if (p_.t.heavy[wire] && light && p_.t.stage[wire] == kStored) cost += p_.t.heavy_weight;
    light = light || !p_.t.heavy[wire];
    for (const SoftConstraint& soft : p_.soft_before[wire])
      if (!picked[soft.wire]) cost += soft.weight;
    last = wire;
  }
  for (const Ranking& ranking : p_.rankings) {
    RankCounter picked_before(ranking.ranks());
    for (int i = 0; i < n_; ++i) {
      const int rank = ranking.of(order[i]);
      if (rank < 0) continue;
      cost += ranking.weight() * picked_before.above(rank);
      picked_before.add(rank);
    }
  }
  return cost + arcs_.cost(last, n_);
}

void OneArmSearch::anneal(std::int64_t moves, double from, double to) {
  if (n_ - low_ < 1) return;
  if (!neighbours_) neighbours_ = std::make_unique<Neighbours>(arcs_);
  // The temperature changes in steps that are too small to matter and large enough to be cheap.
  const std::int64_t step = std::max<std::int64_t>(1, moves / 256);
  double temperature = from;
  for (std::int64_t i = 0; i < moves; ++i) {
    if (i % step == 0) temperature = from * std::pow(to / from, static_cast<double>(i) / moves);
    Exchange move;
    if (!propose(move) || !allowed(move)) continue;
    const Cost loss = change(move);
    // Below exp(-20) an acceptance is not to be expected within any run.
    if (loss > 0 && (loss > 20 * temperature || loss > random_.allowance(temperature))) continue;
    make(move);
    cost_ += loss;
    if (cost_ < best_cost_) {
      best_ = sequence_;
      best_cost_ = cost_;
    }
  }
}

// A block of some wires, and a place for it: beside a near wire, or a few places away.
bool OneArmSearch::propose(Exchange& move) {
  const int first = low_ + random_.below(n_ - low_ + 1);
  const std::uint32_t dice = random_.next();
  int length = 1;
  if ((dice & 15) >= 7) length = (dice & 15) < 12 ? 2 + (dice >> 4) % 3 : 1 + (dice >> 4) % 50;
  const int last = std::min(n_, first + length - 1);
  int after;   // the place after which the block is to stand
  switch (dice >> 28) {
    case 0: case 1: case 2: case 3: case 4: case 5:
      after = position_[neighbours_->any_before(sequence_[first], random_)];
      break;
    case 6: case 7: case 8: case 9: case 10: case 11:
      after = position_[neighbours_->any_after(sequence_[last], random_)] - 1;
      break;
    case 12: after = low_ - 1 + random_.below(n_ - low_ + 2); break;
    default: after = first - 12 + random_.below(24 + last - first);
  }
  if (after < low_ - 1 || after > n_) return false;
  if (after > last)
    move = {first, last, after};
  else if (after < first - 1)
    move = {after + 1, first - 1, last};
  else
    return false;
  return true;
}

bool OneArmSearch::allowed(const Exchange& move) const {
  if (move.middle - move.left < move.right - move.middle) {
    for (int i = move.left; i <= move.middle; ++i)
      for (int next : p_.after[sequence_[i]])
        if (position_[next] > move.middle && position_[next] <= move.right) return false;
  } else {
    for (int i = move.middle + 1; i <= move.right; ++i)
      for (int previous : p_.before[sequence_[i]])
        if (position_[previous] >= move.left && position_[previous] <= move.middle) return false;
  }
  return true;
}

Cost OneArmSearch::change(const Exchange& move) const {
  const int* s = sequence_.data();
  const int a = s[move.left - 1], b = s[move.left], c = s[move.middle], d = s[move.middle + 1],
            e = s[move.right], f = s[move.right + 1];
  Cost loss = arcs_.cost(a, d) + arcs_.cost(e, b) + arcs_.cost(c, f) - arcs_.cost(a, b) -
             arcs_.cost(c, d) - arcs_.cost(e, f);
  if (p_.t.softs) loss += change_of_soft_constraints(move);
  if (p_.t.rankings) loss += change_of_rankings(move);
  if (first_light_ >= move.left)
    loss -= p_.t.heavy_weight * (first_light_after(move) - first_light_);
  return loss;
}

Cost OneArmSearch::change_of_soft_constraints(const Exchange& move) const {
  const bool left_shorter = move.middle - move.left < move.right - move.middle;
  const int from = left_shorter ? move.left : move.middle + 1;
  const int to = left_shorter ? move.middle : move.right;
  const int low = left_shorter ? move.middle + 1 : move.left;
  const int high = left_shorter ? move.right : move.middle;
  Cost loss = 0;
  for (int i = from; i <= to; ++i) {
    const int wire = sequence_[i];
    for (const SoftConstraint& soft : p_.soft_after[wire])
      if (position_[soft.wire] >= low && position_[soft.wire] <= high) loss += soft.weight;
    for (const SoftConstraint& soft : p_.soft_before[wire])
      if (position_[soft.wire] >= low && position_[soft.wire] <= high) loss -= soft.weight;
  }
  return left_shorter ? loss : -loss;
}

Cost OneArmSearch::change_of_rankings(const Exchange& move) const {
  const bool left_shorter = move.middle - move.left < move.right - move.middle;
  const int from = left_shorter ? move.left : move.middle + 1;
  const int to = left_shorter ? move.middle : move.right;
  const int low = left_shorter ? move.middle + 1 : move.left;
  const int high = left_shorter ? move.right : move.middle;
  Cost loss = 0;
  for (std::size_t k = 0; k < ranked_.size(); ++k) {
    const int* ranks = ranked_[k].data();
    int pairs = 0;
    for (int i = from; i <= to; ++i)
      if (ranks[i] >= 0) pairs += balance(ranks + low, high - low + 1, ranks[i]);
    loss += p_.rankings[k].weight() * pairs;
  }
  return left_shorter ? loss : -loss;
}

// The first light wire's place after a move that does not lie behind it.
int OneArmSearch::first_light_after(const Exchange& move) const {
  int place = move.left;
  for (int i = move.middle + 1; i <= move.right; ++i, ++place)
    if (!p_.t.heavy[sequence_[i]]) return place;
  for (int i = move.left; i <= move.middle; ++i, ++place)
    if (!p_.t.heavy[sequence_[i]]) return place;
  return first_light_;
}

void OneArmSearch::make(const Exchange& move) {
  if (first_light_ >= move.left) first_light_ = first_light_after(move);
  std::rotate(sequence_.begin() + move.left, sequence_.begin() + move.middle + 1,
              sequence_.begin() + move.right + 1);
  for (int i = move.left; i <= move.right; ++i) position_[sequence_[i]] = i;
  for (std::vector<int>& ranks : ranked_)
    std::rotate(ranks.begin() + move.left, ranks.begin() + move.middle + 1,
                ranks.begin() + move.right + 1);
}

}  // namespace remodel
