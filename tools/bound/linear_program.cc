#include "tools/bound/linear_program.h"

#include <dlfcn.h>

#include <algorithm>
#include <string>

#include "base/check.h"
#include "base/index.h"

namespace muster::tools {
namespace {

/// A library of COIN-OR that stays loaded.
class Library {
 public:
  Library(const char* file, const char* package) : file_(file), package_(package) {
    handle_ = dlopen(file, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (handle_ == nullptr) Missing();
  }
  template <class Function>
  void Find(const char* name, Function* function) const {
    *function = reinterpret_cast<Function>(dlsym(handle_, name));
    if (*function == nullptr) Missing();
  }

 private:
  [[noreturn]] void Missing() const {
    throw SystemError(std::string("this needs ") + file_ + " (Debian: apt-get install " + package_ +
                      ")");
  }
  const char *file_, *package_;
  void* handle_;
};

constexpr double kNoLimit = 1e30;

}  // namespace

/// Clp's C interface (coin/Clp_C_Interface.h, version 1.17), as far as it is used here.
struct LinearProgram::Clp {
  using Model = void;
  Model* (*create)();
  void (*destroy)(Model*);
  void (*set_log_level)(Model*, int);
  void (*load)(Model*, int columns, int rows, const int* start, const int* index,
               const double* value, const double* column_low, const double* column_high,
               const double* objective, const double* row_low, const double* row_high);
  void (*add_columns)(Model*, int number, const double* low, const double* high,
                      const double* objective, const int* starts, const int* rows,
                      const double* elements);
  int (*primal)(Model*, int if_values_pass);
  double (*value)(Model*);
  double* (*row_prices)(Model*);
  Model* model = nullptr;
};

LinearProgram::LinearProgram(std::span<const double> limits)
    : clp_(std::make_unique<Clp>()), limits_(limits.begin(), limits.end()) {
  static const Library library("libClp.so.1", "coinor-libclp1");
  library.Find("Clp_newModel", &clp_->create);
  library.Find("Clp_deleteModel", &clp_->destroy);
  library.Find("Clp_setLogLevel", &clp_->set_log_level);
  library.Find("Clp_loadProblem", &clp_->load);
  library.Find("Clp_addColumns", &clp_->add_columns);
  library.Find("Clp_primal", &clp_->primal);
  library.Find("Clp_objectiveValue", &clp_->value);
  library.Find("Clp_dualRowSolution", &clp_->row_prices);
  clp_->model = clp_->create();
  clp_->set_log_level(clp_->model, 0);
  const std::vector<double> low(limits_.size(), -kNoLimit);
  const int none = 0;
  clp_->load(clp_->model, 0, static_cast<int>(limits_.size()), &none, nullptr, nullptr, nullptr,
             nullptr, nullptr, low.data(), limits_.data());
}

LinearProgram::~LinearProgram() { clp_->destroy(clp_->model); }

void LinearProgram::AddColumn(double worth, std::span<const Entry> entries) {
  worth_.push_back(worth);
  for (const Entry& entry : entries) {
    rows_.push_back(entry.row);
    factors_.push_back(entry.factor);
  }
  starts_.push_back(static_cast<int>(rows_.size()));
}

void LinearProgram::Solve() {
  const std::size_t n = columns() - loaded_;
  // It makes the least of the sum, so what columns are worth goes in as what they cost.
  std::vector<double> low(n, 0), high(n, kNoLimit), cost;
  std::vector<int> starts;
  for (std::size_t c = loaded_; c < columns(); ++c) cost.push_back(-worth_[c]);
  const int before = starts_[loaded_];
  for (std::size_t c = loaded_; c <= columns(); ++c) starts.push_back(starts_[c] - before);
  if (n > 0) {
    clp_->add_columns(clp_->model, static_cast<int>(n), low.data(), high.data(), cost.data(),
                      starts.data(), rows_.data() + before, factors_.data() + before);
  }
  loaded_ = columns();
  if (clp_->primal(clp_->model, 0) != 0) throw SystemError("Clp does not solve the linear program");
}

double LinearProgram::value() const { return -clp_->value(clp_->model); }

std::vector<double> LinearProgram::Prices() const {
  const double* const of = clp_->row_prices(clp_->model);
  std::vector<double> prices;
  for (std::size_t row = 0; row < limits_.size(); ++row) {
    prices.push_back(std::max(0.0, -of[row]));
  }
  return prices;
}

}  // namespace muster::tools
