#include "simulation.hpp"

#include <limits>

namespace remodel {
namespace {
constexpr int kNever = std::numeric_limits<int>::max();
}

Cost broken_across_blocks(const Problem& p, const WireList& list) {
  if (list.order.empty() || list.block[list.order.back()] == 0) return 0;
  Cost cost = 0;
  for (int i = 0; i < p.t.softs; ++i) {
    const int* row = p.t.soft + 3 * i;
    if (list.block[row[0]] > list.block[row[1]]) cost += row[2];
  }
  for (const Ranking& ranking : p.rankings) {
    RankCounter before(ranking.ranks());
    int pairs = 0;
    for (std::size_t i = 0, from = 0; i < list.order.size(); ++i) {
      const int wire = list.order[i];
      for (; list.block[list.order[from]] < list.block[wire]; ++from)
        if (ranking.of(list.order[from]) >= 0) before.add(ranking.of(list.order[from]));
      if (ranking.of(wire) >= 0) pairs += before.above(ranking.of(wire));
    }
    cost += ranking.weight() * pairs;
  }
  return cost;
}

Simulator::Simulator(const Problem& problem)
    : p_(problem),
      wire_stamp_(problem.t.wires),
      routed_at_(problem.t.wires),
      inserted_at_(2 * problem.t.wires),
      picked_(problem.t.wires),
      located_at_(problem.t.components),
      located_stamp_(problem.t.components),
      picked_ranks_(problem.rankings.size()) {}

Entry Simulator::start() const {
  Entry entry{};
  for (int arm = 0; arm < p_.t.arms; ++arm) {
    entry.tool[arm] = p_.t.arm_tool[arm];
    entry.colour[arm] = p_.t.arm_colour[arm];
    entry.cable[arm] = p_.t.arm_cable[arm];
    entry.zone[arm] = p_.t.arm_zone[arm];
  }
  entry.light = p_.t.light_started;
  entry.carried = -1;
  return entry;
}

bool Simulator::run(const WireList& list, int block, int from, int to, Entry& entry,
                    BlockCost& cost, std::vector<Action>* record, int clock) {
  ++run_;
  list_ = &list;
  block_ = block;
  entry_ = entry;
  entry_.carried = -1;
  cost_ = BlockCost{};
  handed_over_ = false;
  for (std::vector<int>& ranks : picked_ranks_) ranks.clear();
  record_ = record;
  clock_ = clock;
  enqueue(list, from, to, entry.carried);
  for (;;) {
    int index = 0;
    int start = earliest(arms_[0], 0);
    if (p_.t.arms > 1) {
      const int other = earliest(arms_[1], 1);
      if (other < start) index = 1, start = other;
    }
    if (start == kNever) {
      for (int arm = 0; arm < p_.t.arms; ++arm)
        if (arms_[arm].phase != Phase::idle) return false;
      break;
    }
    begin(arms_[index], index, start);
    if (handed_over_) break;
  }
  for (int arm = 0; arm < p_.t.arms; ++arm) {
    cost_.duration = std::max(cost_.duration, arms_[arm].ready);
    entry_.tool[arm] = arms_[arm].tool;
  }
  entry = entry_;
  cost = cost_;
  return true;
}

void Simulator::enqueue(const WireList& list, int from, int to, int carried) {
  for (int index = 0; index < p_.t.arms; ++index) {
    Arm& arm = arms_[index];
    arm.queue.clear();
    arm.next = 0;
    arm.ready = 0;
    arm.tool = entry_.tool[index];
    arm.at = carried < 0 ? p_.start(index) : p_.handover(carried);
    arm.last_kind = -1;
    arm.last_end = 0;
  }
  if (carried >= 0) {
    wire_stamp_[carried] = run_;
    routed_at_[carried] = inserted_at_[2 * carried] = inserted_at_[2 * carried + 1] = kNever;
    arms_[1 - Mode::arm(list.mode[carried])].queue.push_back(carried);
  }
  for (int i = from; i < to; ++i) {
    const int wire = list.order[i], mode = list.mode[wire];
    wire_stamp_[wire] = run_;
    picked_[wire] = p_.t.stage[wire] != kStored;
    routed_at_[wire] = p_.t.stage[wire] >= kRouted ? 0 : kNever;
    inserted_at_[2 * wire] = inserted_at_[2 * wire + 1] = kNever;
    arms_[Mode::arm(mode)].queue.push_back(wire);
    if (Mode::hands_over(mode)) arms_[1 - Mode::arm(mode)].queue.push_back(wire);
  }
  for (int index = 0; index < p_.t.arms; ++index) take_wire(list, arms_[index], index);
}

// Let an arm turn to the next wire of its queue.
void Simulator::take_wire(const WireList& list, Arm& arm, int index) {
  if (arm.next == static_cast<int>(arm.queue.size())) {
    arm.phase = Phase::idle;
    return;
  }
  const int wire = arm.wire = arm.queue[arm.next++];
  const int mode = list.mode[wire];
  arm.first = Mode::first(mode);
  arm.receiver = Mode::hands_over(mode) && Mode::arm(mode) != index;
  if (arm.receiver) {
    arm.phase = list.block[wire] < block_ ? Phase::route : Phase::change_tool;
  } else {
    switch (p_.t.stage[wire]) {
      case kStored: arm.phase = Phase::change_tool; break;
      case kHeld: arm.phase = p_.t.jammed[wire] < 0 ? Phase::locate_first : Phase::extract; break;
      case kFirstIn: arm.phase = Phase::route; break;
      case kHalf: arm.phase = Phase::hand_over; break;
      case kGiven: arm.phase = Phase::route; break;
      case kRouted: arm.phase = p_.t.jammed[wire] < 0 ? Phase::locate_second : Phase::extract; break;
      default: arm.phase = Phase::fix;
    }
  }
  prepare(arm, index);
}

void Simulator::aim(Arm& arm, Point from, Point to, int duration) {
  arm.from = from;
  arm.to = to;
  arm.duration = duration;
  arm.base = arm.ready + p_.travel(arm.at, from);
}

// Work out the next action of an arm, stepping over what needs no doing.
void Simulator::prepare(Arm& arm, int index) {
  const int wire = arm.wire, first = arm.first, second = 1 - first;
  if (arm.phase == Phase::change_tool && arm.tool == p_.t.tool[wire])
    arm.phase = arm.receiver ? Phase::receive : Phase::pick;
  if (arm.phase == Phase::locate_first && located(p_.component(wire, first)))
    arm.phase = Phase::insert_first;
  if (arm.phase == Phase::locate_second && located(p_.component(wire, second)))
    arm.phase = Phase::insert_second;
  const Point a = p_.end(wire, first), b = p_.end(wire, second);
  switch (arm.phase) {
    case Phase::change_tool: {
      const Point station = p_.station(index);
      return aim(arm, station, station, p_.t.change_tool);
    }
    case Phase::pick: return aim(arm, p_.slot(wire), p_.slot(wire), p_.t.pick[wire]);
    case Phase::extract: {
      const Point at = p_.end(wire, p_.t.jammed[wire]);
      return aim(arm, at, at, p_.t.extract);
    }
    case Phase::locate_first: return aim(arm, a, a, p_.t.locate);
    case Phase::insert_first: return aim(arm, a, a, p_.t.insert[2 * wire + arm.first]);
    case Phase::route: {
      const int* part = p_.t.handover_route + 2 * wire;
      if (arm.receiver || p_.t.stage[wire] == kGiven)
        return aim(arm, p_.handover(wire), b, part[second]);
      if (Mode::hands_over(list_->mode[wire])) return aim(arm, a, p_.handover(wire), part[first]);
      return aim(arm, a, b, p_.t.route[wire]);
    }
    case Phase::hand_over:
    case Phase::receive: return aim(arm, p_.handover(wire), p_.handover(wire), p_.t.hand_over);
    case Phase::locate_second: return aim(arm, b, b, p_.t.locate);
    case Phase::insert_second: return aim(arm, b, b, p_.t.insert[2 * wire + 1 - arm.first]);
    case Phase::fix: return aim(arm, b, b, p_.t.fix[wire]);
    case Phase::idle: return;
  }
}

bool Simulator::located_before(const WireList& list, int component, int block) const {
  if (p_.t.located[component]) return true;
  for (const End& e : p_.ends_at[component])
    if (list.end_block(e.wire, e.end) < block && locates(list, e)) return true;
  return false;
}

bool Simulator::locates(const WireList& list, const End& e) const {
  const int stage = p_.t.stage[e.wire];
  const bool in_at_start = stage == kSecondIn ||
                           (stage >= kFirstIn && e.end == Mode::first(list.mode[e.wire]));
  return !in_at_start;
}

bool Simulator::located(int component) const {
  return located_stamp_[component] == run_ || located_before(*list_, component, block_);
}

// The earliest start of an arm's next action, as far as the actions begun so far show.
int Simulator::earliest(Arm& arm, int index) {
  if (arm.phase == Phase::idle || arm.phase == Phase::receive) return kNever;
  const Arm& other = arms_[1 - index];
  if (arm.phase == Phase::hand_over) {
    if (p_.t.arms < 2 || other.phase != Phase::receive || other.wire != arm.wire) return kNever;
    return std::max(arm.base, other.base);
  }
  if (arm.phase == Phase::locate_first || arm.phase == Phase::locate_second)
    if (located_stamp_[key(arm)] == run_) prepare(arm, index);
  const int order = wait_for_order(arm);
  if (order == kNever) return kNever;
  int start = std::max(arm.base, order);
  if (p_.t.arms > 1) {
    start = wait_for_other(arm, other, start);
    // The other arm may begin its next action before this one starts; then this alone decides.
    if (start > order) arm.base = start;
  }
  return start;
}

int Simulator::wait_for_order(const Arm& arm) const {
  int start = 0;
  if (arm.phase == Phase::route) {
    for (int wire : p_.under[arm.wire])
      if (list_->second_block(wire) >= block_) start = std::max(start, routed_at_[wire]);
  } else if (arm.phase == Phase::insert_first || arm.phase == Phase::insert_second) {
    const int end = arm.phase == Phase::insert_first ? arm.first : 1 - arm.first;
    for (const End& e : p_.pins[end][arm.wire])
      if (list_->end_block(e.wire, e.end) >= block_)
        start = std::max(start, inserted_at_[2 * e.wire + e.end]);
    const int component = p_.component(arm.wire, end);
    if (located_stamp_[component] == run_) start = std::max(start, located_at_[component]);
  }
  return start;
}

// What an action takes for itself, besides its kind: a component, or a wire's ducts.
int Simulator::key(const Arm& arm) const {
  switch (arm.phase) {
    case Phase::route: return arm.wire;
    case Phase::extract: return p_.component(arm.wire, p_.t.jammed[arm.wire]);
    case Phase::locate_first:
    case Phase::insert_first: return p_.component(arm.wire, arm.first);
    case Phase::locate_second:
    case Phase::insert_second:
    case Phase::fix: return p_.component(arm.wire, 1 - arm.first);
    default: return -1;
  }
}

namespace {

bool at_component(int kind) {
  return kind == kLocate || kind == kInsert || kind == kFix || kind == kExtract;
}

}  // namespace

// Starts never decrease, so that only the action that the other arm began last can be under way.
int Simulator::wait_for_other(const Arm& arm, const Arm& other, int start) const {
  if (other.last_kind < 0 || other.last_end <= start) return start;
  bool excluded = false;
  switch (arm.phase) {
    case Phase::pick: excluded = other.last_kind == kPick; break;
    case Phase::route:
      excluded = other.last_kind == kRoute && p_.ducts_shared(arm.wire, other.last_key);
      break;
    case Phase::locate_first:
    case Phase::locate_second:
      excluded = other.last_kind == kLocate ||
                 (at_component(other.last_kind) && other.last_key == key(arm));
      break;
    case Phase::insert_first:
    case Phase::insert_second:
    case Phase::fix:
    case Phase::extract:
      excluded = at_component(other.last_kind) && other.last_key == key(arm);
      break;
    default: break;
  }
  return excluded ? other.last_end : start;
}

// Begin the next action of an arm, and let its effects come true.
void Simulator::begin(Arm& arm, int index, int start) {
  const int wire = arm.wire, first = arm.first, end = start + arm.duration;
  int kind = kFix, detail = 0;
  const int taken = key(arm);
  arm.ready = end;
  arm.at = arm.to;
  switch (arm.phase) {
    case Phase::change_tool:
      kind = kChangeTool;
      detail = arm.tool = p_.t.tool[wire];
      cost_.penalty += p_.t.tool_weight;
      break;
    case Phase::pick:
      kind = kPick;
      count_pick(wire, index);
      arm.phase = Phase::locate_first;
      break;
    case Phase::extract:
      kind = kExtract;
      detail = p_.t.jammed[wire];
      arm.phase = p_.t.stage[wire] == kHeld ? Phase::locate_first : Phase::locate_second;
      break;
    case Phase::locate_first:
    case Phase::locate_second:
      kind = kLocate;
      detail = arm.phase == Phase::locate_first ? first : 1 - first;
      located_stamp_[taken] = run_;
      located_at_[taken] = end;
      break;
    case Phase::insert_first:
      kind = kInsert;
      detail = first;
      inserted_at_[2 * wire + first] = end;
      arm.phase = Phase::route;
      break;
    case Phase::route:
      kind = kRoute;
      if (Mode::hands_over(list_->mode[wire]) && !arm.receiver) {
        detail = 2;
        arm.phase = Phase::hand_over;
      } else {
        detail = 1 - first;
        routed_at_[wire] = end;
        arm.phase = Phase::locate_second;
      }
      break;
    case Phase::hand_over:
      kind = kHandOver;
      detail = 1 - index;
      arms_[1 - index].ready = end;
      entry_.carried = wire;
      handed_over_ = true;
      break;
    case Phase::insert_second:
      kind = kInsert;
      detail = 1 - first;
      inserted_at_[2 * wire + 1 - first] = end;
      arm.phase = Phase::fix;
      break;
    default: break;
  }
  if (record_) record_->push_back({kind, index, wire, detail, clock_ + start});
  arm.last_kind = kind;
  arm.last_key = taken;
  arm.last_end = end;
  if (kind == kFix)
    take_wire(*list_, arm, index);
  else
    prepare(arm, index);
}

void Simulator::count_pick(int wire, int index) {
  const WiringTables& t = p_.t;
  if (entry_.colour[index] >= 0) {
    cost_.penalty += t.colour_weight * (entry_.colour[index] != t.colour[wire]) +
                     t.zone_weight * std::max(0, entry_.zone[index] - t.zone[wire]);
  } else if (index == 0) {
    cost_.penalty += t.start_weight * t.zone[wire];
  }
  cost_.penalty += p_.cable_penalty(entry_.cable[index], wire);
  entry_.colour[index] = t.colour[wire];
  entry_.cable[index] = t.cable[wire];
  entry_.zone[index] = t.zone[wire];
  if (t.heavy[wire] && entry_.light) cost_.penalty += t.heavy_weight;
  entry_.light = entry_.light || !t.heavy[wire];
  if (t.preferred_arm[wire] >= 0 && t.preferred_arm[wire] != index) cost_.penalty += t.arm_weight;
  picked_[wire] = 1;
  for (const SoftConstraint& soft : p_.soft_before[wire])
    if (list_->block[soft.wire] == block_ && !picked_[soft.wire]) cost_.penalty += soft.weight;
  for (std::size_t k = 0; k < picked_ranks_.size(); ++k) {
    const int rank = p_.rankings[k].of(wire);
    if (rank < 0) continue;
    std::vector<int>& picked = picked_ranks_[k];
    const auto broken = std::count_if(picked.begin(), picked.end(), [rank](int r) { return r > rank; });
    cost_.penalty += p_.rankings[k].weight() * static_cast<int>(broken);
    picked.push_back(rank);
  }
}

}  // namespace remodel
