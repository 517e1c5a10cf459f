vantage_benchmark(fusion_bench SOURCES fusion_bench.cc LINK vantage_fusion)
