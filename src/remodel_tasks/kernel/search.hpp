// What the searches for one and for two arms have in common.
#pragma once

#include <cstdint>

#include "ranking.hpp"

namespace remodel {

class Search {
 public:
  virtual ~Search() = default;
  // Build a first plan. False if there is none: the arms would wait for each other.
  virtual bool construct() = 0;
  // Start from an order of the wires and the mode of each; the order must satisfy the constraints.
  virtual bool adopt(const int* order, const int* modes) = 0;
  // Anneal for some moves, from one temperature to another [tick].
  virtual void anneal(std::int64_t moves, double from, double to) = 0;
  virtual void return_to_best() = 0;
  // Write the best order, and the mode of each wire by its number.
  virtual void best(int* order, int* modes) const = 0;
  // Cost of the best plan, up to a constant of the problem.
  virtual Cost best_cost() const = 0;
};

}  // namespace remodel
