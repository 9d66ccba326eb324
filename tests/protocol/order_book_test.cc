#include "protocol/order_book.h"

#include <gtest/gtest.h>

#include "model/generator.h"

namespace muster {
namespace {

Scenario Roomy() {
  Scenario scenario = Generate(PresetByName("Random_1"), 1);
  AddRoom({5, {}}, &scenario);
  return scenario;
}

/// Adds task `id` at x = `km`.
taken_order_t Add(std::int32_t id, int km) {
  taken_order_t order{};
  order.id = "add-" + std::to_string(id);
  order.issuer = "test";
  order.json =
      R"({"order": "task_add", "task": {"x_km": )" + std::to_string(km) + R"(, "y_km": 1}})";
  order.task_id = id;
  order.agent_id = -1;
  return order;
}

orders_t At(std::int64_t tick, std::int64_t before, std::vector<taken_order_t> taken,
            std::int64_t boot_id = 0) {
  orders_t orders{};
  orders.header.sender = "world";
  orders.header.boot_id = boot_id;
  orders.tick = tick;
  orders.before = before;
  orders.taken = std::move(taken);
  orders.n_taken = static_cast<std::int32_t>(orders.taken.size());
  return orders;
}

double X_km(const OrderBook& book, std::size_t task) {
  return book.scenario()->tasks[task].at.x_m / 1000;
}

TEST(OrderBook, FillsTheScenarioInPlace) {
  OrderBook book(Roomy());
  const Scenario* const scenario = book.scenario().get();
  EXPECT_FALSE(book.complete(0));
  EXPECT_TRUE(book.Take(At(0, 0, {})));
  EXPECT_TRUE(book.complete(0));
  EXPECT_TRUE(book.Take(At(1, 0, {Add(120, 7)})));
  EXPECT_EQ(book.scenario().get(), scenario);
  EXPECT_EQ(scenario->n_tasks(), 121u);
  EXPECT_EQ(X_km(book, 120), 7);
  EXPECT_EQ(book.TakenAt(1).size(), 1u);
  EXPECT_TRUE(book.knows("add-120"));
}

/// A damaged packet may say of how many orders it comes behind, and be right otherwise.
TEST(OrderBook, ATickThatWasHeardDamagedIsReadWhenItIsSaidAgain) {
  OrderBook book(Roomy());
  EXPECT_TRUE(book.Take(At(0, 0, {})));
  EXPECT_TRUE(book.Take(At(1, 4, {})));
  EXPECT_FALSE(book.complete(1));
  EXPECT_TRUE(book.Take(At(1, 0, {})));
  EXPECT_TRUE(book.complete(1));
  EXPECT_TRUE(book.Take(At(2, 16, {Add(120, 7)})));
  EXPECT_FALSE(book.complete(2));
  EXPECT_TRUE(book.Take(At(2, 0, {Add(120, 7)})));
  EXPECT_TRUE(book.complete(2));
  EXPECT_EQ(X_km(book, 120), 7);
}

TEST(OrderBook, WhatIsSaidAgainIsReadAgainOnlyIfItDiffers) {
  OrderBook book(Roomy());
  orders_t both = At(0, 0, {Add(120, 7)});
  refused_order_t refused{};
  refused.id = "other";
  both.refused = {refused};
  EXPECT_TRUE(book.Take(both));
  std::int64_t version = book.version();
  both.header.boot_id = 3;  // a world that has started again
  EXPECT_TRUE(book.Take(both));
  EXPECT_EQ(book.version(), version);
  const auto is_read = [&](const auto& change) {
    orders_t changed = both;
    change(&changed);
    EXPECT_TRUE(book.Take(changed));
    const bool is_new = book.version() != version;
    EXPECT_TRUE(book.Take(both));
    version = book.version();
    return is_new;
  };
  EXPECT_TRUE(is_read([](orders_t* o) { o->taken[0] = Add(120, 9), o->taken[0].id = "add-120"; }));
  EXPECT_TRUE(is_read([](orders_t* o) { o->taken[0].id = "add"; }));
  EXPECT_TRUE(is_read([](orders_t* o) { o->refused[0].id = "another"; }));
  EXPECT_TRUE(is_read([](orders_t* o) { o->refused.clear(); }));
}

TEST(OrderBook, WaitsForWhatIsMissing) {
  OrderBook book(Roomy());
  EXPECT_TRUE(book.Take(At(5, 1, {Add(121, 8)})));
  EXPECT_FALSE(book.complete(5));
  EXPECT_EQ(book.scenario()->n_tasks(), 120u);
  EXPECT_TRUE(book.Take(At(3, 0, {Add(120, 7)})));
  EXPECT_TRUE(book.complete(5));
  EXPECT_EQ(X_km(book, 121), 8);
}

TEST(OrderBook, TakesSomebodyElsesWord) {
  OrderBook told(Roomy()), book(Roomy());
  ASSERT_TRUE(told.Take(At(3, 0, {Add(120, 7)})));
  ASSERT_TRUE(told.Take(At(4, 1, {})));
  order_book_t wire = told.ToWire();
  EXPECT_EQ(wire.tick, 4);
  EXPECT_EQ(wire.ticks.size(), 1u);
  ASSERT_TRUE(book.Take(wire));
  EXPECT_TRUE(book.complete(4));
  EXPECT_EQ(X_km(book, 120), 7);
  ASSERT_TRUE(book.Take(At(6, 1, {Add(121, 8)})));
  EXPECT_TRUE(book.complete(6));
  EXPECT_EQ(book.UpTo(5).scenario()->n_tasks(), 121u);
  EXPECT_EQ(book.UpTo(6).scenario()->n_tasks(), 122u);
}

TEST(OrderBook, BelievesTheLaterStartOfTheWorld) {
  OrderBook book(Roomy());
  ASSERT_TRUE(book.Take(At(3, 0, {Add(120, 7)})));
  ASSERT_TRUE(book.Take(At(3, 0, {Add(120, 9)}, 1)));
  EXPECT_EQ(X_km(book, 120), 9);
  ASSERT_TRUE(book.Take(At(3, 0, {Add(120, 7)})));
  EXPECT_EQ(X_km(book, 120), 9);
  EXPECT_TRUE(book.complete(3, 1));
  EXPECT_FALSE(book.complete(3, 2));
  // It may take nothing of what the earlier one took.
  ASSERT_TRUE(book.Take(At(3, 0, {}, 2)));
  EXPECT_EQ(book.scenario()->n_tasks(), 120u);
  EXPECT_FALSE(book.knows("add-120"));
}

TEST(OrderBook, KnowsWhatWasRefusedToo) {
  OrderBook book(Roomy());
  orders_t orders = At(2, 0, {});
  refused_order_t refused{};
  refused.id = "late";
  orders.refused = {refused};
  orders.n_refused = 1;
  ASSERT_TRUE(book.Take(orders));
  EXPECT_TRUE(book.knows("late"));
  EXPECT_EQ(book.scenario()->n_tasks(), 120u);
  // The next order is the second one, so the refused one is counted.
  ASSERT_TRUE(book.Take(At(3, 1, {Add(120, 7)})));
  EXPECT_TRUE(book.complete(3));
  EXPECT_EQ(X_km(book, 120), 7);
}

TEST(OrderBook, AQuietTickIsCompleteWhoeverToldOfIt) {
  OrderBook told(Roomy()), book(Roomy());
  ASSERT_TRUE(told.Take(At(3, 0, {Add(120, 7)})));
  ASSERT_TRUE(told.Take(At(4, 1, {})));
  ASSERT_TRUE(book.Take(told.ToWire()));  // which leaves out tick 4
  EXPECT_TRUE(book.complete(4, 9));
  EXPECT_FALSE(book.complete(3, 9)) << "an earlier start of the world said it";
  ASSERT_TRUE(book.Take(At(4, 1, {}))) << "the quiet tick itself comes later";
  EXPECT_EQ(X_km(book, 120), 7);
  EXPECT_FALSE(book.complete(5));
}

TEST(OrderBook, TakesNothingOfAnAccountThatCannotBe) {
  OrderBook told(Roomy()), book(Roomy());
  ASSERT_TRUE(told.Take(At(3, 0, {Add(120, 7)})));
  order_book_t wire = told.ToWire();
  for (const auto& spoil : std::vector<void (*)(taken_order_t&)>{
           [](taken_order_t& o) { o.json = "{}"; }, [](taken_order_t& o) { o.task_id = 121; },
           [](taken_order_t& o) { o.agent_id = 0; }}) {
    order_book_t bad = wire;
    spoil(bad.ticks[0].taken[0]);
    EXPECT_FALSE(book.Take(bad));
    EXPECT_EQ(book.scenario()->n_tasks(), 120u);
    EXPECT_FALSE(book.knows("add-120"));
    EXPECT_FALSE(book.complete(3));
  }
  EXPECT_TRUE(book.Take(wire));
  EXPECT_EQ(book.scenario()->n_tasks(), 121u);
}

TEST(OrderBook, RefusesWhatCannotBe) {
  OrderBook book(Roomy());
  EXPECT_FALSE(book.Take(At(3, 0, {Add(121, 7)})));  // the next is 120
  EXPECT_EQ(book.scenario()->n_tasks(), 120u);
  EXPECT_TRUE(book.Take(At(3, 0, {Add(120, 7)})));
  EXPECT_FALSE(book.Take(At(1'000'000, 1, {})));
  Scenario closed = Generate(PresetByName("Random_1"), 1);
  OrderBook none(closed);
  EXPECT_FALSE(none.Take(At(0, 0, {})));
  EXPECT_TRUE(none.complete(100));
}

}  // namespace
}  // namespace muster
