#include "scheduler/process/scheduler_main.h"

int main(int argc, char** argv) { return muster::scheduler::SchedulerMain(argc, argv); }
