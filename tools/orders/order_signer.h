#pragma once

#include <optional>
#include <string>

#include "base/options.h"
#include "model/scenario.h"
#include "tools/orders/persons.h"

namespace muster::tools {

/// --sign FILE, of each command that gives orders.
void AddSignOption(Options* options);
/// "": not given.
std::string SigningKeyFile(const Arguments& arguments);

/// Signs orders to one running mission with a person's own key.
class OrderSigner {
 public:
  /// RUN is the run directory of the mission. Throws InputError.
  OrderSigner(const std::string& key_file, const std::string& run);

  /// The order with its signature. Text that is no order stays as it is: the mission says what is
  /// wrong with it.
  std::string Sign(const std::string& order) const;

 private:
  PersonKey key_;
  std::int64_t run_id_ = 0;
  std::optional<Origin> origin_;
};

}  // namespace muster::tools
