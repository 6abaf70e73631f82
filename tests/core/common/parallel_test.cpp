#include <recon/errors.h>
#include <recon/parallel.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>

using namespace recon;

TEST(ParallelFor, VisitsEveryItemOnceWithAnyNumberOfThreads)
{
    for (const int threads : {1, 2, 3, 8})
    {
        std::vector<int> visits(10'001, 0);
        parallel_for(visits.size(), threads, {}, [&](std::size_t i) { ++visits[i]; });
        EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), 0), 10'001);
        EXPECT_EQ(*std::max_element(visits.begin(), visits.end()), 1);
    }
    parallel_for(0, 2, {}, [](std::size_t) { FAIL(); });
}

TEST(ParallelCollect, ListsWhatIsFoundInTheOrderOfTheItems)
{
    for (const int threads : {1, 3})
    {
        const std::vector<int> thirds = parallel_collect<int>(
            1000, threads, {},
            [](std::size_t i, std::vector<int>& found)
            {
                if (i % 3 == 0)
                    found.push_back(int(i));
            },
            7);
        ASSERT_EQ(thirds.size(), 334u);
        for (std::size_t k = 0; k < thirds.size(); ++k)
            EXPECT_EQ(thirds[k], int(3 * k));
    }
}

TEST(ResolveThreads, GivesAtLeastOneAndNotMoreThanAMachineCanStart)
{
    EXPECT_GE(resolve_threads(0), 1);
    EXPECT_EQ(resolve_threads(3), 3);
    EXPECT_LT(resolve_threads(std::numeric_limits<int>::max()), 1000);
    EXPECT_THROW(resolve_threads(-1), InvalidInput);
}

TEST(ParallelFor, PassesOnWhatTheBodyThrows)
{
    EXPECT_THROW(parallel_for(
                     1000, 3, {},
                     [](std::size_t i)
                     {
                         if (i == 500)
                             throw InvalidInput("x");
                     },
                     10),
                 InvalidInput);
}

TEST(ParallelFor, ReportsOnTheCallersThreadAndStopsWhenAsked)
{
    const auto caller = std::this_thread::get_id();
    std::atomic<int> calls{0};
    const Progress progress(
        [&](double fraction, const std::string&)
        {
            EXPECT_EQ(std::this_thread::get_id(), caller);
            EXPECT_LE(fraction, 1);
            return ++calls < 3;
        });
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    const auto body = [&](std::size_t)
    {
        // A helper must not take all the chunks while the caller's thread waits for a core.
        while (std::this_thread::get_id() != caller && calls < 3 && std::chrono::steady_clock::now() < deadline)
            std::this_thread::yield();
    };
    EXPECT_THROW(parallel_for(1'000'000, 2, progress, body, 1), Cancelled);
    EXPECT_EQ(calls, 3);
}

namespace
{

/// Unlike std::thread::id no thread ever has that of another that ended.
int number_of_this_thread()
{
    static std::atomic<int> threads{0};
    thread_local const int number = threads++;
    return number;
}

std::chrono::steady_clock::time_point deadline()
{
    return std::chrono::steady_clock::now() + std::chrono::seconds(10);
}

template <class Condition>
void wait_until(const Condition& holds)
{
    for (const auto end = deadline(); !holds() && std::chrono::steady_clock::now() < end;)
        std::this_thread::yield();
}

} // namespace

TEST(ThreadTeam, HelpsInAllLoopsOfItsLife)
{
    const auto list_threads = [&](int loops)
    {
        std::mutex mutex;
        std::set<int> seen;
        for (int loop = 0; loop < loops; ++loop)
        {
            std::atomic<int> begun{0};
            const auto body = [&](std::size_t)
            {
                ++begun;
                wait_until([&] { return begun == 3; }); // all threads are at it
                const std::lock_guard<std::mutex> lock(mutex);
                seen.insert(number_of_this_thread());
            };
            parallel_for(3, 3, {}, body, 1);
        }
        return seen;
    };
    EXPECT_EQ(list_threads(5).size(), 11u);
    const ThreadTeam team;
    {
        const ThreadTeam within;
        EXPECT_EQ(list_threads(5).size(), 3u);
    }
    EXPECT_EQ(list_threads(50).size(), 3u);
}

// Most helpers come too late.
TEST(ThreadTeam, VisitsEveryItemOfShortLoopsOnce)
{
    const ThreadTeam team;
    for (int loop = 0; loop < 3000; ++loop)
    {
        std::atomic<int> visits{0};
        parallel_for(
            4, 4, {}, [&](std::size_t) { ++visits; }, 1);
        ASSERT_EQ(visits, 4);
    }
    EXPECT_THROW(parallel_for(
                     100, 3, {}, [](std::size_t) { throw InvalidInput("x"); }, 10),
                 InvalidInput);
}

TEST(ThreadTeam, DoesNotHoldUpALoopWithinALoop)
{
    const int caller = number_of_this_thread();
    const ThreadTeam team;
    std::atomic<int> begun{0}, visits{0};
    std::atomic<bool> is_within_done{false};
    const auto body = [&](std::size_t)
    {
        ++begun;
        wait_until([&] { return begun == 2; });
        if (number_of_this_thread() == caller)
        {
            parallel_for(
                100, 3, {}, [&](std::size_t) { ++visits; }, 10);
            is_within_done = true;
        }
        wait_until([&] { return is_within_done.load(); });
        EXPECT_TRUE(is_within_done);
    };
    parallel_for(2, 2, {}, body, 1);
    EXPECT_EQ(visits, 100);
}

TEST(ParallelInvoke, RunsBothAndPassesOnFailures)
{
    for (const int threads : {1, 2})
    {
        int done = 0, other = 0;
        parallel_invoke(
            threads, [&] { ++done; }, [&] { ++other; });
        EXPECT_EQ(done + other, 2);
        EXPECT_THROW(parallel_invoke(
                         threads, [] {}, [] { throw InvalidInput("x"); }),
                     InvalidInput);
        EXPECT_THROW(parallel_invoke(
                         threads, [] { throw Cancelled(); }, [] {}),
                     Cancelled);
    }
}

TEST(Progress, MapsPartsAndNeverFalls)
{
    std::vector<double> seen;
    std::vector<std::string> phases;
    const Progress progress(
        [&](double fraction, const std::string& phase)
        {
            seen.push_back(fraction);
            phases.push_back(phase);
            return true;
        });
    const Progress half = progress.part(0, 0.5, "first");
    half.part(0.5, 1, "inner").report(1);
    half.report(0.1);
    progress.part(0.5, 1, "second").report(0.5);
    EXPECT_EQ(seen, (std::vector<double>{0.5, 0.5, 0.75}));
    EXPECT_EQ(phases, (std::vector<std::string>{"inner", "first", "second"}));
}
