// What the arms do with a list of wires: a chronological simulation, one block at a time.
//
// The plan of the search is a list of all wires, each with a mode. An arm does the wires that its
// modes give it, in the list's order; whichever arm can start its next action first, starts it (a
// tie goes to the first arm). An action waits for its arm's travel, for the ends and routes that
// must be there before, and for the action of the other arm that excludes it. A component is
// located by the arm that needs it first, just before the insertion. If the list satisfies the order of
// the wires, one of the arms can always go on.
//
// A handover needs both arms, all wires before it in the list are then done or in hand, and none
// after it is begun: handovers cut the list into blocks whose durations add up. A block depends on
// the earlier ones only by its Entry and by the set of wires in them. So a changed list costs the
// simulation of the blocks that changed, and this is what makes the two-arm search fast.
//
// test/decoder.py is the plain reference; a test holds the two equal.
#pragma once

#include <vector>

#include "problem.hpp"

namespace remodel {

enum ActionKind : std::int32_t {
  kChangeTool, kPick, kLocate, kInsert, kRoute, kHandOver, kFix, kExtract
};

struct Action {
  // detail: tool; end of the wire (0, 1); for a route also 2, the handover; the receiving arm.
  std::int32_t kind, arm, wire, detail, start;
};

// The state between two blocks; the arms stand at the handover point of the carried wire.
struct Entry {
  int tool[2], colour[2], cable[2], zone[2];
  bool light;         // a wire that is not heavy has been picked
  int carried = -1;   // wire handed over last, now in the hand of its receiver

  bool operator==(const Entry& o) const {
    for (int arm = 0; arm < 2; ++arm)
      if (tool[arm] != o.tool[arm] || colour[arm] != o.colour[arm] || cable[arm] != o.cable[arm] ||
          zone[arm] != o.zone[arm])
        return false;
    return light == o.light && carried == o.carried;
  }
};

struct BlockCost {
  int duration = 0;   // [tick] until the handover has ended, or the last arm has
  Cost penalty = 0;
};

// The list of wires with what the simulation asks about it.
struct WireList {
  std::vector<int> order, position, mode, block;

  int second_block(int wire) const { return block[wire] + Mode::hands_over(mode[wire]); }
  int end_block(int wire, int end) const {
    return end == Mode::first(mode[wire]) ? block[wire] : second_block(wire);
  }
};

// What a list costs for soft constraints and ranks between wires of different blocks.
Cost broken_across_blocks(const Problem& problem, const WireList& list);

class Simulator {
 public:
  explicit Simulator(const Problem& problem);

  // The entry of the first block.
  Entry start() const;

  // Simulate the block of wires list.order[from .. to - 1]; entry becomes that of the next block.
  // False where the arms wait for each other. Actions are appended to record, if there is one,
  // with their starts counted from `clock`.
  bool run(const WireList& list, int block, int from, int to, Entry& entry, BlockCost& cost,
           std::vector<Action>* record = nullptr, int clock = 0);

  // Whether an end is yet to be inserted, so that its component must have been located.
  bool locates(const WireList& list, const End& e) const;

 private:
  enum class Phase {
    change_tool, pick, extract, locate_first, insert_first, route, hand_over,
    locate_second, insert_second, fix, receive, idle
  };
  struct Arm {
    Point at;
    int ready, tool, wire, first;
    bool receiver;                 // of the wire at hand: it comes, or came, from the other arm
    Phase phase;
    int next;                      // index into queue
    std::vector<int> queue;
    int base, duration;            // of the next action: start without waiting, length [tick]
    Point from, to;
    int last_kind, last_key, last_end;   // the action begun last
  };

  void enqueue(const WireList& list, int from, int to, int carried);
  void take_wire(const WireList& list, Arm& arm, int index);
  void prepare(Arm& arm, int index);
  void aim(Arm& arm, Point from, Point to, int duration);
  bool located(int component) const;
  bool located_before(const WireList& list, int component, int block) const;
  int earliest(Arm& arm, int index);
  int wait_for_order(const Arm& arm) const;
  int wait_for_other(const Arm& arm, const Arm& other, int start) const;
  void begin(Arm& arm, int index, int start);
  void count_pick(int wire, int index);
  int key(const Arm& arm) const;

  const Problem& p_;
  const WireList* list_ = nullptr;
  int block_ = 0;
  Arm arms_[2];
  Entry entry_;
  BlockCost cost_;
  bool handed_over_ = false;
  std::vector<Action>* record_ = nullptr;
  int clock_ = 0;
  // Times within this block, valid where the stamp is the number of this run.
  int run_ = 0;
  std::vector<int> wire_stamp_, routed_at_, inserted_at_, picked_, located_at_, located_stamp_;
  std::vector<std::vector<int>> picked_ranks_;   // of this block, for each ranking
};

}  // namespace remodel
