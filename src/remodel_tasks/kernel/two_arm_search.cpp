#include "two_arm_search.hpp"

#include <limits>

#include "two_arm_greedy.hpp"

namespace remodel {
namespace {
// Parts with handovers that would cross more blocks than these are not worth their simulation.
constexpr int kMostBlocks = 6;
}  // namespace

TwoArmSearch::TwoArmSearch(const Problem& problem, std::uint64_t seed)
    : p_(problem), simulator_(problem), random_(seed), n_(problem.t.wires), low_(problem.t.openings) {}

bool TwoArmSearch::construct() {
  std::vector<int> order, modes;
  Cost least = std::numeric_limits<Cost>::max();
  for (int surcharge : {0, 2 * p_.t.heavy_weight, 20 * p_.t.heavy_weight})
    for (int by_rank = 0; by_rank <= !p_.rankings.empty(); ++by_rank) {
      const ListPlan plan = greedy_list(p_, surcharge, by_rank);
      std::vector<int> by_wire(n_);
      for (std::size_t i = 0; i < plan.order.size(); ++i) by_wire[plan.order[i]] = plan.modes[i];
      if (adopt(plan.order.data(), by_wire.data()) && cost_ < least) {
        least = cost_;
        order = plan.order;
        modes = by_wire;
      }
    }
  return least < std::numeric_limits<Cost>::max() && adopt(order.data(), modes.data());
}

bool TwoArmSearch::adopt(const int* order, const int* modes) {
  list_.order.assign(order, order + n_);
  list_.mode.assign(modes, modes + n_);
  if (!evaluate_all()) return false;
  best_order_ = list_.order;
  best_modes_ = list_.mode;
  best_cost_ = cost_;
  return true;
}

void TwoArmSearch::best(int* order, int* modes) const {
  std::copy(best_order_.begin(), best_order_.end(), order);
  std::copy(best_modes_.begin(), best_modes_.end(), modes);
}

void TwoArmSearch::return_to_best() {
  list_.order = best_order_;
  list_.mode = best_modes_;
  evaluate_all();
}

bool TwoArmSearch::evaluate_all() {
  list_.position.assign(n_, 0);
  list_.block.assign(n_, 0);
  int handovers = 0;
  for (int wire : list_.order) handovers += Mode::hands_over(list_.mode[wire]);
  blocks_.assign(handovers + 1, Block{});
  marked_.assign(handovers + 1, 1);
  marked_to_ = handovers;
  blocks_[0].entry = simulator_.start();
  blocks_[handovers].to = n_;
  renumber(0, n_ - 1);
  replaced_.clear();
  cost_ = 0;
  soft_cost_ = broken_across_blocks(p_, list_);
  if (!simulate_marked(0)) return false;
  cost_ += soft_cost_;
  return true;
}

// Bring positions, blocks and block borders up to date where the list has changed.
void TwoArmSearch::renumber(int left, int right) {
  int block = 0;
  if (left > 0) {
    const int previous = list_.order[left - 1];
    block = list_.block[previous] + Mode::hands_over(list_.mode[previous]);
  }
  for (int i = left; i <= right; ++i) {
    const int wire = list_.order[i];
    list_.position[wire] = i;
    list_.block[wire] = block;
    if (Mode::hands_over(list_.mode[wire])) {
      blocks_[block].to = i + 1;
      blocks_[++block].from = i + 1;
    }
  }
}

void TwoArmSearch::mark(int block) {
  marked_[block] = 1;
  marked_to_ = std::max(marked_to_, block);
}

// Simulate the marked blocks from the first on; cost_ and replaced_ hold what has changed.
bool TwoArmSearch::simulate_marked(int from) {
  for (int b = from; b <= marked_to_; ++b) {
    if (!marked_[b]) continue;
    marked_[b] = 0;
    Block& block = blocks_[b];
    replaced_.emplace_back(b, block);
    if (b > 0) block.entry = blocks_[b - 1].exit;
    const Entry before = block.exit;
    cost_ -= block.cost.duration + block.cost.penalty;
    block.exit = block.entry;
    if (!simulator_.run(list_, b, block.from, block.to, block.exit, block.cost)) {
      for (; b <= marked_to_; ++b) marked_[b] = 0;
      marked_to_ = -1;
      return false;
    }
    cost_ += block.cost.duration + block.cost.penalty;
    if (b + 1 < static_cast<int>(blocks_.size()) && !(before == block.exit)) mark(b + 1);
  }
  marked_to_ = -1;
  return true;
}

// The block in which a component is needed, and thus located, first.
int TwoArmSearch::first_block(int component) const {
  int first = std::numeric_limits<int>::max();
  for (const End& e : p_.ends_at[component])
    if (simulator_.locates(list_, e)) first = std::min(first, list_.end_block(e.wire, e.end));
  return first;
}

void TwoArmSearch::anneal(std::int64_t moves, double from, double to) {
  if (n_ - low_ < 1) return;
  if (!neighbours_) neighbours_ = std::make_unique<Neighbours>(Arcs(p_, 0));
  const std::int64_t step = std::max<std::int64_t>(1, moves / 256);
  double temperature = from;
  for (std::int64_t i = 0; i < moves; ++i) {
    if (i % step == 0) temperature = from * std::pow(to / from, static_cast<double>(i) / moves);
    Move move;
    if (!propose(move) || !allowed(move) || !matters(move)) continue;
    if (try_move(move, random_.allowance(temperature)) && cost_ < best_cost_) {
      best_order_ = list_.order;
      best_modes_ = list_.mode;
      best_cost_ = cost_;
    }
  }
}

int TwoArmSearch::random_mode(int wire) {
  const unsigned bits = p_.t.modes[wire];
  int skip = random_.below(__builtin_popcount(bits));
  for (int mode = 0;; ++mode)
    if (bits >> mode & 1 && skip-- == 0) return mode;
}

bool TwoArmSearch::propose(Move& move) {
  const int first = low_ + random_.below(n_ - low_);
  const std::uint32_t dice = random_.next();
  int length = 1;
  if ((dice & 15) >= 10) length = (dice & 15) < 14 ? 2 + (dice >> 4) % 2 : 1 + (dice >> 4) % kLongestPart;
  const int last = std::min(n_ - 1, first + length - 1);
  move.first = first;
  move.last = last;
  int after, beside = -1;   // the position after which the part is to stand; the wire beside it
  switch (dice >> 28) {
    case 0: case 1: case 2: case 3: case 4:
      beside = neighbours_->any_before(list_.order[first], random_);
      after = list_.position[beside];
      break;
    case 5: case 6: case 7:
      beside = neighbours_->any_after(list_.order[last], random_);
      after = list_.position[beside] - 1;
      break;
    case 8: case 9: case 10: after = first - 1; break;
    case 11: after = low_ - 1 + random_.below(n_ - low_ + 1); break;
    default: after = first - 16 + random_.below(32 + last - first);
  }
  if (after < low_ - 1 || after >= n_) return false;
  if (after > last) {
    move.left = first, move.middle = last, move.right = after;
  } else if (after < first - 1) {
    move.left = after + 1, move.middle = first - 1, move.right = last;
  } else {
    move.left = first, move.middle = move.right = last;
    beside = -1;
  }
  propose_modes(move, beside);
  return move.middle < move.right || move.changes_modes;
}

// New modes for the part: the arm of the wire beside it where there is one, else by chance.
void TwoArmSearch::propose_modes(Move& move, int beside) {
  move.changes_modes = false;
  const bool in_place = move.middle == move.right;
  const std::uint32_t dice = random_.next();
  for (int i = move.first; i <= move.last; ++i) {
    const int wire = list_.order[i];
    int mode = list_.mode[wire];
    if (in_place || (dice & 3) == 0) {
      mode = random_mode(wire);
    } else if (beside >= 0 && (dice & 3) < 3 && !Mode::hands_over(mode)) {
      const int same = Mode::of(Mode::arm(list_.mode[beside]), Mode::first(mode), false);
      if (p_.has_mode(wire, same)) mode = same;
    }
    move.modes[i - move.first] = mode;
    move.changes_modes = move.changes_modes || mode != list_.mode[wire];
  }
}

bool TwoArmSearch::allowed(const Move& move) const {
  if (move.middle - move.left < move.right - move.middle) {
    for (int i = move.left; i <= move.middle; ++i)
      for (int next : p_.after[list_.order[i]])
        if (list_.position[next] > move.middle && list_.position[next] <= move.right) return false;
  } else {
    for (int i = move.middle + 1; i <= move.right; ++i)
      for (int previous : p_.before[list_.order[i]])
        if (list_.position[previous] >= move.left && list_.position[previous] <= move.middle)
          return false;
  }
  return true;
}

// A move that changes the order of no arm changes nothing.
bool TwoArmSearch::matters(const Move& move) const {
  if (move.changes_modes) return true;
  int left = 0, right = 0;   // bit set of the arms that each part occupies
  for (int i = move.left; i <= move.middle; ++i) {
    const int mode = list_.mode[list_.order[i]];
    left |= Mode::hands_over(mode) ? 3 : 1 << Mode::arm(mode);
  }
  for (int i = move.middle + 1; i <= move.right && !(left & right); ++i) {
    const int mode = list_.mode[list_.order[i]];
    right |= Mode::hands_over(mode) ? 3 : 1 << Mode::arm(mode);
  }
  return left & right;
}

void TwoArmSearch::exchange(int left, int middle, int right) {
  std::rotate(list_.order.begin() + left, list_.order.begin() + middle + 1,
              list_.order.begin() + right + 1);
}

// Give the part its new modes, and let it change places with its neighbour.
void TwoArmSearch::make(const Move& move) {
  for (int i = move.first; i <= move.last; ++i)
    list_.mode[list_.order[i]] = move.modes[i - move.first];
  exchange(move.left, move.middle, move.right);
}

bool TwoArmSearch::try_move(const Move& move, double allowance) {
  Part part;
  part.count = move.last - move.first + 1;
  int handovers_more = 0;
  for (int i = 0; i < part.count; ++i) {
    const int wire = part.wires[i] = list_.order[move.first + i];
    part.modes[i] = list_.mode[wire];
    part.blocks[i] = list_.block[wire];
    for (int end = 0; end < 2; ++end)
      part.first_blocks[i][end] = first_block(p_.component(wire, end));
    const int now = Mode::hands_over(part.modes[i]), then = Mode::hands_over(move.modes[i]);
    part.hands_over = part.hands_over || now || then;
    handovers_more += then - now;
  }
  if (handovers_more != 0) return try_with_other_blocks(move, part, allowance);
  const int low = list_.block[list_.order[move.left]];
  const int high = list_.second_block(list_.order[move.right]);
  if (part.hands_over && high - low > kMostBlocks) return false;

  const Cost old_cost = cost_, old_soft_cost = soft_cost_;
  make(move);
  renumber(move.left, move.right);
  replaced_.clear();
  if (mark_touched(part, low, high)) {
    soft_cost_ = broken_across_blocks(p_, list_);
    cost_ += soft_cost_ - old_soft_cost;
  }
  if (simulate_marked(low) && cost_ - old_cost <= allowance) return true;

  for (int i = 0; i < part.count; ++i) list_.mode[part.wires[i]] = part.modes[i];
  exchange(move.left, move.left + move.right - move.middle - 1, move.right);
  renumber(move.left, move.right);
  for (const auto& [b, old] : replaced_) {
    blocks_[b].entry = old.entry;
    blocks_[b].exit = old.exit;
    blocks_[b].cost = old.cost;
  }
  cost_ = old_cost;
  soft_cost_ = old_soft_cost;
  return false;
}

// Mark the blocks that a move has touched; true if a wire is in another block than before.
bool TwoArmSearch::mark_touched(const Part& part, int low, int high) {
  bool moved = part.hands_over;
  if (part.hands_over)
    for (int b = low; b <= std::min(high + 1, static_cast<int>(blocks_.size()) - 1); ++b) mark(b);
  for (int i = 0; i < part.count; ++i) {
    const int wire = part.wires[i], block = list_.block[wire];
    moved = moved || block != part.blocks[i];
    mark(part.blocks[i]);
    mark(block);
    for (int end = 0; end < 2; ++end) {
      const int before = part.first_blocks[i][end], now = first_block(p_.component(wire, end));
      if (now != before) mark(std::max(now, before));
    }
  }
  return moved;
}

// A wire that is handed over, and was not, makes a block more: all is counted again.
bool TwoArmSearch::try_with_other_blocks(const Move& move, const Part& part, double allowance) {
  const std::vector<int> old_order = list_.order;
  const Cost old_cost = cost_;
  make(move);
  if (evaluate_all() && cost_ - old_cost <= allowance) return true;
  list_.order = old_order;
  for (int i = 0; i < part.count; ++i) list_.mode[part.wires[i]] = part.modes[i];
  evaluate_all();
  return false;
}

}  // namespace remodel
