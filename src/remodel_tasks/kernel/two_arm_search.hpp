// List of wires and mode of each for two arms, improved by annealing on exact costs.
//
// The one move exchanges two neighbouring parts of the list, of which one may get new modes. It is
// made, the blocks that it touches are simulated again (simulation.hpp), and it is taken back if the
// cost does not please. Touched are: the blocks that wires leave and enter, a block whose first use
// of a component is no longer its first in the plan (or has become it), and after those every block
// whose entry differs from before.
#pragma once

#include <memory>
#include <vector>

#include "arcs.hpp"
#include "neighbours.hpp"
#include <remodel_tasks/random.hpp>
#include "search.hpp"
#include "simulation.hpp"

namespace remodel {

class TwoArmSearch final : public Search {
 public:
  TwoArmSearch(const Problem& problem, std::uint64_t seed);

  bool construct() override;
  bool adopt(const int* order, const int* modes) override;
  void anneal(std::int64_t moves, double from, double to) override;
  void return_to_best() override;
  void best(int* order, int* modes) const override;
  Cost best_cost() const override { return best_cost_; }

 private:
  struct Block {
    int from, to;          // positions [from, to) of the list
    Entry entry, exit;
    BlockCost cost;
  };
  static constexpr int kLongestPart = 8;
  struct Move {
    int left, middle, right;   // parts left..middle and middle+1..right change places
    int first, last;           // positions of the part that gets new modes
    int modes[kLongestPart];
    bool changes_modes;
  };
  // The part of a move that gets new modes, as it was before.
  struct Part {
    int count;
    bool hands_over = false;   // a wire of it is handed over, before or after
    int wires[kLongestPart], modes[kLongestPart], blocks[kLongestPart];
    int first_blocks[kLongestPart][2];   // in which the components of its ends were needed first
  };

  bool propose(Move& move);
  void propose_modes(Move& move, int beside);
  int random_mode(int wire);
  bool allowed(const Move& move) const;
  bool matters(const Move& move) const;
  bool try_move(const Move& move, double allowance);
  bool try_with_other_blocks(const Move& move, const Part& part, double allowance);
  bool mark_touched(const Part& part, int low, int high);
  void make(const Move& move);
  void exchange(int left, int middle, int right);
  void renumber(int left, int right);
  bool evaluate_all();
  bool simulate_marked(int from);
  int first_block(int component) const;
  void mark(int block);

  const Problem& p_;
  Simulator simulator_;
  std::unique_ptr<const Neighbours> neighbours_;
  Random random_;
  int n_, low_;
  WireList list_;
  std::vector<Block> blocks_;
  std::vector<std::pair<int, Block>> replaced_;
  std::vector<char> marked_;
  int marked_to_ = -1;
  Cost soft_cost_ = 0, cost_ = 0, best_cost_ = 0;
  std::vector<int> best_order_, best_modes_;
};

}  // namespace remodel
