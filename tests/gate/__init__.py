"""`make same BASE=REVISION`: which numbers of results.json differ between two trees."""
