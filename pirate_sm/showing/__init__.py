"""What every view of a run shares: words for people, a canvas of characters. No view itself."""
