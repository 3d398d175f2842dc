"""What is read from datasets: claims, comparisons, shares, summaries."""
